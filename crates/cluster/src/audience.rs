//! The sensors that concern a cell.

use std::collections::BTreeMap;

use asterix::DataSource;

/// Sensors whose messages are delivered to a cell. Messages of a sensor that is not listed are delivered to every cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Audience(BTreeMap<DataSource, bool>);

impl Audience {
    /// Whether messages of each sensor are delivered.
    pub(super) const fn of(sensors: BTreeMap<DataSource, bool>) -> Self {
        Self(sensors)
    }

    /// Whether messages of that sensor are delivered.
    pub fn includes(&self, sensor: DataSource) -> bool {
        self.0.get(&sensor).copied().unwrap_or(true)
    }
}
