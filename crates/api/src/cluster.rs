//! `/api/v1/cluster`: members of the cluster.

use axum::http::StatusCode;

use super::problem::Problem;
use super::request::ApiRequest;
use service::live::ClusterMembers;

/// Cells, nodes and gateways of the cluster.
pub fn members(request: &ApiRequest) -> Result<ClusterMembers, Problem> {
    let Some(members) = request.state.hub.members() else {
        return Err(Problem::new(
            StatusCode::NOT_FOUND,
            "this is one machine, or nothing is known of the cluster yet",
        ));
    };
    Ok(ClusterMembers::clone(&members))
}
