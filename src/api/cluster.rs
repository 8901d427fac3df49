//! `/api/v1/cluster`: who makes the picture.

use axum::http::StatusCode;

use super::ask::Ask;
use super::problem::Problem;
use crate::live::Members;

/// The members of the cluster.
pub fn members(ask: &Ask) -> Result<Members, Problem> {
    let Some(members) = ask.state.hub.members() else {
        return Err(Problem::new(
            StatusCode::NOT_FOUND,
            "this is one machine, or nothing is known of the cluster yet",
        ));
    };
    Ok(Members::clone(&members))
}
