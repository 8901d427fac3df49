//! The metrics, one file each.

pub(super) mod association;
pub(super) mod false_tracks;
pub(super) mod ghosts;
pub(super) mod gospa;
pub(super) mod identity;
pub(super) mod nees;
pub(super) mod scene;
pub(super) mod statistics;
pub(super) mod update;
