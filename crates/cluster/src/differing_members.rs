//! Members of a region whose configuration differs.

use super::gateway_report::GatewayReport;
use super::log::{Log, LogError};
use super::node_report::NodeReport;
use super::shared_configuration::SharedConfiguration;

/// A member with another configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConfigurationDifference {
    /// Role and name, such as `node n1`.
    pub member: String,
    /// Differing keys with both values.
    pub text: String,
}

impl SharedConfiguration {
    /// Members whose reports state another configuration.
    ///
    /// # Errors
    /// The log does not answer.
    pub async fn differing_members(
        &self,
        log: &Log,
        nodes: &[NodeReport],
        gateways: &[GatewayReport],
    ) -> Result<Vec<ConfigurationDifference>, LogError> {
        let own = self.hash();
        let nodes = nodes.iter().map(|node| (format!("node {}", node.holder.node), node.holder.config));
        let gateways = gateways.iter().map(|gateway| (format!("gateway {}", gateway.node), gateway.config));
        let mut different = Vec::new();
        for (member, stated) in nodes.chain(gateways).filter(|(_, stated)| !Self::accepts(own, *stated)) {
            let text = match log.configuration(stated).await? {
                Some(there) => self.differences(&there),
                None => "in what cannot be read".to_owned(),
            };
            different.push(ConfigurationDifference { member, text });
        }
        Ok(different)
    }
}
