//! Labels: which drone each plot and each transponder really was.

mod transponders;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Range, RangeInclusive};

use self::transponders::Transponders;
use crate::config::{Config, SensorKind};
use fusion::time::Time;

/// A row of `labels.csv`: what one plot or one transponder report was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The time of the plot or report.
    pub time: Time,
    /// The id of the sensor in the configuration.
    pub sensor: String,
    /// The radar's track number (I048/161), or a number of the transponder: the service's, where `identity` is not stated or is
    /// that number in decimal.
    pub number: u32,
    /// The drone's id in the truth; `None`: no drone (a bird, clutter).
    pub id: Option<String>,
    /// Whether the radar's track had walked off its target.
    pub seduced: bool,
    /// The name of the transponder's identity as the service knows it: serial number, ICAO address in hexadecimal, ...; `None`
    /// of a radar or a camera, and where it is not stated.
    pub identity: Option<String>,
}

/// What labels say about a contributor of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attribution<'a> {
    /// The drone; `None`: no drone.
    pub id: Option<&'a str>,
    /// Whether the radar track was seduced at that time.
    pub seduced: bool,
}

/// The labels of a flight, looked up by number and time.
#[derive(Clone, Debug, Default)]
pub struct Labels {
    rows: Vec<Label>,
    receivers: BTreeSet<String>,
    /// By track number and sensor of a radar: its rows by time, of equal times in the order of the file.
    radar: BTreeMap<u32, BTreeMap<String, Vec<usize>>>,
    transponders: Transponders,
}

impl Labels {
    /// Labels whose transponder receivers are inferred: a sensor is taken for a receiver if its numbers and drones are one
    /// to one over the whole file, since a transponder stays on its drone while a radar also numbers birds and new tracks.
    /// A radar that never does is taken for a receiver, too; where two sensors then disagree, the labels are silent.
    /// Where rows state identities, the sensors that do are the receivers.
    pub fn new(rows: Vec<Label>) -> Self {
        let receivers = receivers(&rows);
        Self::with_receivers(rows, &receivers)
    }

    /// Labels with known transponder receivers, by sensor id; all other sensors are radars.
    pub fn with_receivers(rows: Vec<Label>, receivers: &BTreeSet<String>) -> Self {
        Self::with(rows, receivers, |_| true, &BTreeMap::new())
    }

    /// Labels of a site: its configuration knows which sensors are receivers and which are cameras, whose track numbers no
    /// point states, and to which serial numbers it gives a number.
    pub fn of_site(rows: Vec<Label>, config: &Config) -> Self {
        let of_kind = |is_wanted: fn(&SensorKind) -> bool| -> BTreeSet<String> {
            let wanted = config.sensors.iter().filter(|sensor| is_wanted(&sensor.kind));
            wanted.map(|sensor| sensor.id.clone()).collect()
        };
        let receivers = of_kind(|kind| kind.receiver().is_some());
        let cameras = of_kind(|kind| matches!(kind, SensorKind::Camera(_)));
        let is_radar = |sensor: &str| !cameras.contains(sensor);
        Self::with(rows, &receivers, is_radar, &config.fusion.transponder_numbers)
    }

    /// `is_radar` is asked of sensors that are no receivers; `given`: the service's numbers by serial number.
    fn with(
        rows: Vec<Label>,
        receivers: &BTreeSet<String>,
        is_radar: impl Fn(&str) -> bool,
        given: &BTreeMap<String, u32>,
    ) -> Self {
        let mut labels = Self { rows, receivers: receivers.clone(), ..Self::default() };
        for (place, row) in labels.rows.iter().enumerate() {
            if receivers.contains(&row.sensor) {
                labels.transponders.insert(row, given);
            } else if is_radar(&row.sensor) {
                let of_number = labels.radar.entry(row.number).or_default();
                of_number.entry(row.sensor.clone()).or_default().push(place);
            }
        }
        for places in labels.radar.values_mut().flat_map(BTreeMap::values_mut) {
            places.sort_by_key(|&place| labels.rows[place].time); // stable
        }
        labels
    }

    /// The rows as given.
    pub fn rows(&self) -> &[Label] {
        &self.rows
    }

    /// What the radar track with this number was, by its latest plot in `span`. Without `sensor` all radars with such a plot
    /// must agree. `None` where the labels are silent.
    pub fn radar_track(
        &self,
        number: u16,
        sensor: Option<&str>,
        span: &Range<Time>,
    ) -> Option<Attribution<'_>> {
        self.agreed(number, sensor, |places| {
            let until = places.partition_point(|&place| self.rows[place].time < span.end);
            let latest = &self.rows[places[until.checked_sub(1)?]];
            (latest.time >= span.start).then_some(latest)
        })
    }

    /// What the radar track with this number was at `time`, between plots: by the last one before and the first one after,
    /// within `span`. `None` where these disagree, as when a number passes from one target to another.
    pub fn radar_track_near(
        &self,
        number: u16,
        sensor: Option<&str>,
        time: Time,
        span: &RangeInclusive<Time>,
    ) -> Option<Attribution<'_>> {
        self.agreed(number, sensor, |places| {
            let after = places.partition_point(|&place| self.rows[place].time < time);
            let row = |&place: &usize| Some(&self.rows[place]).filter(|row| span.contains(&row.time));
            let before = after.checked_sub(1).and_then(|before| row(&places[before]));
            match (before, places.get(after).and_then(row)) {
                (Some(before), Some(after)) => (before.id == after.id).then_some(after),
                (before, after) => before.or(after),
            }
        })
    }

    /// What the plots say that `choose` picks from each radar's, which are in order of time.
    fn agreed<'a>(
        &'a self,
        number: u16,
        sensor: Option<&str>,
        choose: impl Fn(&[usize]) -> Option<&'a Label>,
    ) -> Option<Attribution<'a>> {
        let mut told = None;
        for (name, places) in self.radar.get(&number.into())? {
            if sensor.is_some_and(|sensor| sensor != name) {
                continue;
            }
            let Some(row) = choose(places) else { continue };
            let this = Attribution { id: row.id.as_deref(), seduced: row.seduced };
            if told.is_some_and(|told| told != this) {
                return None;
            }
            told = Some(this);
        }
        told
    }

    /// Who carries the transponder of this identity, where that is known, and with this number of the service's; `None` where
    /// labels are silent or receivers disagree.
    pub fn transponder(&self, identity: Option<&str>, number: u32) -> Option<Attribution<'_>> {
        let ids = self.transponders.carriers(identity, number)?;
        match (ids.first(), ids.len()) {
            (Some(id), 1) => Some(Attribution { id: id.as_deref(), seduced: false }),
            _ => None,
        }
    }

    /// What this drone's plots are labelled with, of every radar.
    pub(super) fn plots_of<'a>(&'a self, id: &'a str) -> impl Iterator<Item = &'a Label> {
        let plots = self.radar.values().flat_map(BTreeMap::values).flatten();
        plots.map(|&place| &self.rows[place]).filter(move |row| row.id.as_deref() == Some(id))
    }

    /// What the reports under this transponder number are labelled with, of every receiver.
    pub(super) fn reports_of(&self, number: u32) -> impl Iterator<Item = &Label> {
        let is_of = move |row: &&Label| row.number == number && row.number_is_of_service();
        self.rows.iter().filter(is_of).filter(|row| self.receivers.contains(&row.sensor))
    }

    /// Ids of the drones that carry a transponder.
    pub fn equipped(&self) -> BTreeSet<&str> {
        self.transponders.carried().collect()
    }
}

/// The sensors that state identities, else those whose numbers and drones are one to one.
fn receivers(rows: &[Label]) -> BTreeSet<String> {
    let named: BTreeSet<String> =
        rows.iter().filter(|row| row.identity.is_some()).map(|row| row.sensor.clone()).collect();
    if !named.is_empty() {
        return named;
    }
    let mut pairs: BTreeMap<&str, BTreeSet<(u32, Option<&str>)>> = BTreeMap::new();
    for row in rows {
        pairs.entry(&row.sensor).or_default().insert((row.number, row.id.as_deref()));
    }
    let one_to_one = |pairs: &BTreeSet<(u32, Option<&str>)>| {
        let numbers: BTreeSet<_> = pairs.iter().map(|pair| pair.0).collect();
        let drones: BTreeSet<_> = pairs.iter().filter_map(|pair| pair.1).collect();
        numbers.len() == pairs.len() && drones.len() == pairs.len()
    };
    pairs.into_iter().filter(|(_, pairs)| one_to_one(pairs)).map(|(name, _)| name.to_owned()).collect()
}

#[cfg(test)]
mod tests;
