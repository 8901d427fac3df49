//! The cells of a region by its configuration: one cell for the whole site, or several adjacent cells.

use std::collections::BTreeMap;

use asterix::DataSource;

use super::audience::Audience;
use super::engine::SiteEngine;
use super::region::{Border, DEFAULT_REACH_M, Region, reach_m};
use fusion::frames::Geodetic;
use fusion::time::Time;
use service::net::listen::lines;
use site::areas::Masks;
use site::config::{Config, Radar, SensorKind};
use site::territory::{CellName, Territory, TerritoryError};

/// Name of the only cell of an undivided region.
pub const WHOLE: &str = "all";
/// The cells of a region.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    names: Vec<CellName>,
    /// Division of the region; `None` for one cell without borders.
    territory: Option<Territory>,
    halo_m: f64,
    hysteresis_m: f64,
}

fn place(radar: &Radar) -> Geodetic {
    Geodetic::from_degrees(radar.latitude_deg, radar.longitude_deg, 0.0)
}

impl Cells {
    /// The cells of a configuration. A grid has the cells that a radar reaches; without radars, the cells near the site's origin.
    ///
    /// # Errors
    /// The grid or the polygons are invalid.
    pub fn of(config: &Config) -> Result<Self, TerritoryError> {
        let whole = || vec![CellName::new(WHOLE).expect("it is a name")];
        let Some(cluster) = &config.cluster else {
            return Ok(Self { names: whole(), territory: None, halo_m: 0.0, hysteresis_m: 0.0 });
        };
        let territory = match cluster.grid_deg {
            Some(degrees) => Some(Territory::grid(degrees)?),
            None if cluster.cells.is_empty() => None,
            None => {
                let cells = cluster.cells.iter().map(|cell| (cell.name.clone(), cell.corners()));
                Some(Territory::polygons(cells.collect())?)
            }
        };
        let names = match &territory {
            None => whole(),
            Some(Territory::Polygons(cells)) => cells.keys().cloned().collect(),
            Some(grid) => {
                let (latitude_deg, longitude_deg, _) = config.origin();
                let origin = [(Geodetic::from_degrees(latitude_deg, longitude_deg, 0.0), DEFAULT_REACH_M)];
                let mut reached: Vec<_> =
                    radars(config).map(|radar| (place(radar), reach_m(radar))).collect();
                if reached.is_empty() {
                    reached.extend(origin);
                }
                let near = reached.into_iter().flat_map(|(place, reach_m)| grid.around(place, reach_m));
                let mut near: Vec<CellName> = near.collect();
                near.sort();
                near.dedup();
                near
            }
        };
        Ok(Self { names, territory, halo_m: cluster.halo_m, hysteresis_m: cluster.hysteresis_m })
    }

    /// Names of the cells, sorted.
    pub fn names(&self) -> &[CellName] {
        &self.names
    }

    /// Whether the region is undivided.
    pub const fn is_whole(&self) -> bool {
        self.territory.is_none()
    }

    /// The geometry of a cell among the others; `None` if it is the only cell or has an unknown name.
    pub fn region(&self, cell: &CellName) -> Option<Region> {
        let territory = self.territory.clone().filter(|_| self.names.contains(cell))?;
        Region::new(territory, self.names.clone(), cell.clone(), self.halo_m, self.hysteresis_m)
    }

    /// Creates a cell's engine, without data. `started` is the current time.
    pub fn engine(&self, config: &Config, masks: Masks, started: Time, cell: &CellName) -> SiteEngine {
        let engine = SiteEngine::new(config.clone(), masks, started);
        match self.region(cell) {
            Some(region) => engine.bordering(Border::new(region)),
            None => engine,
        }
    }

    /// Lines delivered to a cell: all except those that carry only radars whose configured range ends outside the cell.
    pub fn audience(&self, config: &Config, cell: &CellName) -> Audience {
        let Some(region) = self.region(cell) else { return Audience::default() };
        let is_of_use = |sensor: &usize| match &config.sensors[*sensor].kind {
            SensorKind::Radar(radar) => radar
                .max_range_m
                .is_none_or(|range_m| region.outline().is_within(place(radar), range_m + self.halo_m)),
            _ => true,
        };
        let mut audience = BTreeMap::new();
        for line in lines(config) {
            let first = &config.sensors[line.sensors[0]];
            let source = DataSource { sac: first.sac, sic: first.sic };
            *audience.entry(source).or_default() |= line.sensors.iter().any(is_of_use);
        }
        Audience::of(audience)
    }

    /// Cells that a sensor of the configuration can reach, for the output of `check`.
    pub fn of_sensor(&self, config: &Config, sensor: usize) -> Vec<&CellName> {
        let SensorKind::Radar(radar) = &config.sensors[sensor].kind else {
            return self.names.iter().collect();
        };
        let is_near = |cell: &&CellName| {
            let region = self.region(cell);
            region.is_none_or(|region| region.outline().is_within(place(radar), reach_m(radar) + self.halo_m))
        };
        self.names.iter().filter(is_near).collect()
    }

    /// Home cell of each sensor of the configuration: the cell that contains the radar, else the first cell.
    pub fn homes(&self, config: &Config) -> Vec<CellName> {
        let home = |kind: &SensorKind| match (kind, &self.territory) {
            (SensorKind::Radar(radar), Some(territory)) => territory.home(place(radar), &self.names),
            _ => None,
        };
        let first = &self.names[0];
        config.sensors.iter().map(|sensor| home(&sensor.kind).unwrap_or_else(|| first.clone())).collect()
    }

    /// Corners of a cell, longitude and latitude in degrees; empty for an undivided region.
    pub fn corners(&self, cell: &CellName) -> Vec<[f64; 2]> {
        self.region(cell).map(|region| region.outline().corners_deg()).unwrap_or_default()
    }
}

fn radars(config: &Config) -> impl Iterator<Item = &Radar> {
    config.sensors.iter().filter_map(|sensor| match &sensor.kind {
        SensorKind::Radar(radar) => Some(radar),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(cluster: &str) -> Config {
        let text = format!(
            "[site]\nname = \"site\"\nsac = 25\nsic = 100\n[[sensors]]\nid = \"north\"\nkind = \"radar\"\nsac = 25\nsic = 1\n\
             latitude_deg = 51.25\nlongitude_deg = 4.35\nheight_amsl_m = 10\nmax_range_m = 5000\n\
             [[sensors.inputs]]\ngroup = \"239.1.1.1\"\nport = 8048\ninterface = \"127.0.0.1\"\n\
             [[sensors]]\nid = \"drones\"\nkind = \"transponder\"\nsac = 25\nsic = 2\n\
             [[sensors.inputs]]\ngroup = \"239.1.1.2\"\nport = 8129\ninterface = \"127.0.0.1\"\n\
             [cluster]\nservers = [\"nats://127.0.0.1:4222\"]\nnode = \"n\"\nregion = \"r\"\n{cluster}"
        );
        Config::parse(&text, "site.toml", std::iter::empty()).unwrap()
    }

    #[test]
    fn undivided_region_is_one_cell() {
        let config = config("");
        let cells = Cells::of(&config).unwrap();
        assert!(cells.is_whole());
        assert_eq!(cells.names().iter().map(CellName::as_str).collect::<Vec<_>>(), [WHOLE]);
        assert_eq!(cells.region(&cells.names()[0]), None);
        assert!(cells.audience(&config, &cells.names()[0]).includes(DataSource { sac: 25, sic: 1 }));
    }

    #[test]
    fn grid_has_the_squares_that_a_radar_reaches() {
        let config = config("grid_deg = 0.1\n");
        let cells = Cells::of(&config).unwrap();
        let names: Vec<&str> = cells.names().iter().map(CellName::as_str).collect();
        // A range of 5 km from the centre of a square of 11.1 km by 7 km crosses its western and eastern edges.
        assert_eq!(names, ["n512-e0042", "n512-e0043", "n512-e0044"]);
        assert_eq!(cells.region(&cells.names()[1]).unwrap().neighbours().count(), 2);
    }

    #[test]
    fn cell_beyond_a_radars_range_does_not_receive_it() {
        let far = "[[cluster.cells]]\nname = \"near\"\npolygon = [[4.3, 51.2], [4.4, 51.2], [4.4, 51.3], [4.3, 51.3]]\n\
                   [[cluster.cells]]\nname = \"far\"\npolygon = [[4.6, 51.2], [4.7, 51.2], [4.7, 51.3], [4.6, 51.3]]\n";
        let config = config(far);
        let cells = Cells::of(&config).unwrap();
        let [far, near] = cells.names() else { panic!("two cells: {:?}", cells.names()) };
        let [radar, drones] = [1, 2].map(|sic| DataSource { sac: 25, sic });
        let includes = |cell| [radar, drones].map(|sensor| cells.audience(&config, cell).includes(sensor));
        assert_eq!((includes(near), includes(far)), ([true, true], [false, true]));
        assert_eq!((cells.of_sensor(&config, 0), cells.of_sensor(&config, 1)), (vec![near], vec![far, near]));
        assert_eq!(cells.corners(near).len(), 4);
    }
}
