//! Enumerations of a track's JSON: each lists its names for the schema.

use fusion::Source;

/// Which kinds of sensors a track is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackSource {
    /// A radar track and a transponder.
    Fused,
    /// Radar alone.
    Radar,
    /// A transponder alone.
    Transponder,
}

// The history stores positions in this order.
fusion::interface_names!(TrackSource { Fused = "fused", Radar = "radar", Transponder = "transponder" });

impl From<&Source> for TrackSource {
    fn from(source: &Source) -> Self {
        match source {
            Source::Fused(..) => Self::Fused,
            Source::Radar(_) => Self::Radar,
            Source::Transponder(_) => Self::Transponder,
        }
    }
}

/// Whether a track was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackState {
    /// It was.
    Active,
    /// Nothing was measured since; its position is extrapolated.
    Coasting,
}

fusion::interface_names!(TrackState { Active = "active", Coasting = "coasting" });

/// Kind of a sensor that took part in a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContributorKind {
    /// A radar.
    Radar,
    /// A receiver of transponders, ADS-B or Remote ID.
    Transponder,
    /// A camera.
    Camera,
}

fusion::interface_names!(ContributorKind { Radar = "radar", Transponder = "transponder", Camera = "camera" });
