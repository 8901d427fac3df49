//! Labels: the true drone behind each plot and each transponder.

mod transponders;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Range, RangeInclusive};

use self::transponders::LabelledTransponders;
use fusion::time::Time;
use site::config::{Config, SensorKind};

/// A row of `labels.csv`: the origin of one plot or one transponder report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Time of the plot or report.
    pub time: Time,
    /// Id of the sensor in the configuration.
    pub sensor: String,
    /// Track number of the radar (I048/161), or a number of the transponder. It is the service's number if `identity`
    /// is missing or is the same number in decimal.
    pub number: u32,
    /// Id of the drone in the truth; `None`: not a drone (a bird, clutter).
    pub id: Option<String>,
    /// Whether the radar track is seduced, away from its target.
    pub seduced: bool,
    /// Name of the transponder's identity in the service: serial number, ICAO address in hexadecimal, ...; `None` for
    /// radars and cameras, and if not stated.
    pub identity: Option<String>,
}

/// Origin of a contributor of a point, according to the labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attribution<'a> {
    /// Id of the drone; `None`: not a drone.
    pub id: Option<&'a str>,
    /// Whether the radar track was seduced at that time.
    pub seduced: bool,
}

/// Labels of a flight, looked up by number and time.
#[derive(Clone, Debug, Default)]
pub struct Labels {
    rows: Vec<Label>,
    receivers: BTreeSet<String>,
    /// By track number and radar: rows in order of time; at equal times, in the order of the file.
    radar: BTreeMap<u32, BTreeMap<String, Vec<usize>>>,
    transponders: LabelledTransponders,
}

impl Labels {
    /// Labels with inferred transponder receivers.
    ///
    /// If rows state identities, the sensors of these rows are the receivers. Otherwise a sensor is a receiver if its
    /// numbers and drones correspond one to one over the whole file: a transponder stays on its drone, while a radar
    /// also numbers birds and new tracks. A radar whose numbers do correspond is mistaken for a receiver; if two
    /// sensors then disagree, the labels return nothing.
    pub fn new(rows: Vec<Label>) -> Self {
        let receivers = receivers(&rows);
        Self::with_receivers(rows, &receivers)
    }

    /// Labels with known transponder receivers, by sensor id; all other sensors are radars.
    pub fn with_receivers(rows: Vec<Label>, receivers: &BTreeSet<String>) -> Self {
        Self::with(rows, receivers, |_| true, &BTreeMap::new())
    }

    /// Labels of a site. The configuration states which sensors are receivers, which are cameras (whose track numbers
    /// no point states), and which serial numbers have a fixed number.
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

    /// `is_radar` decides for sensors other than receivers; `given` holds the service's numbers by serial number.
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

    /// Returns the rows as given.
    pub fn rows(&self) -> &[Label] {
        &self.rows
    }

    /// Origin of the radar track with this number, by its latest plot in `span`. Without `sensor`, all radars with such
    /// a plot must agree. `None` if the labels do not determine it.
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

    /// Origin of the radar track with this number at `time`, between plots: by the last plot before and the first plot
    /// after, within `span`. `None` if these disagree, as when a number passes from one target to another.
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

    /// Common origin of the plots that `choose` picks from each radar's plots, which are in order of time.
    fn agreed<'a>(
        &'a self,
        number: u16,
        sensor: Option<&str>,
        choose: impl Fn(&[usize]) -> Option<&'a Label>,
    ) -> Option<Attribution<'a>> {
        let mut found = None;
        for (name, places) in self.radar.get(&number.into())? {
            if sensor.is_some_and(|sensor| sensor != name) {
                continue;
            }
            let Some(row) = choose(places) else { continue };
            let this = Attribution { id: row.id.as_deref(), seduced: row.seduced };
            if found.is_some_and(|found| found != this) {
                return None;
            }
            found = Some(this);
        }
        found
    }

    /// Carrier of the transponder with this identity, if known, and with this number of the service. `None` if the
    /// labels do not determine it, or receivers disagree.
    pub fn transponder(&self, identity: Option<&str>, number: u32) -> Option<Attribution<'_>> {
        let ids = self.transponders.carriers(identity, number)?;
        match (ids.first(), ids.len()) {
            (Some(id), 1) => Some(Attribution { id: id.as_deref(), seduced: false }),
            _ => None,
        }
    }

    /// Labels of this drone's plots, of all radars.
    pub(super) fn plots_of<'a>(&'a self, id: &'a str) -> impl Iterator<Item = &'a Label> {
        let plots = self.radar.values().flat_map(BTreeMap::values).flatten();
        plots.map(|&place| &self.rows[place]).filter(move |row| row.id.as_deref() == Some(id))
    }

    /// Labels of the reports under this transponder number, of all receivers.
    pub(super) fn reports_of(&self, number: u32) -> impl Iterator<Item = &Label> {
        let is_of = move |row: &&Label| row.number == number && row.number_is_of_service();
        self.rows.iter().filter(is_of).filter(|row| self.receivers.contains(&row.sensor))
    }

    /// Times at which reports of this drone's transponders were received, in order.
    pub(super) fn report_times(&self, id: &str) -> Vec<Time> {
        let is_report = |row: &&Label| row.id.as_deref() == Some(id) && self.receivers.contains(&row.sensor);
        let mut times: Vec<Time> = self.rows.iter().filter(is_report).map(|row| row.time).collect();
        times.sort_unstable();
        times
    }

    /// Ids of the drones that carry a transponder.
    pub fn equipped(&self) -> BTreeSet<&str> {
        self.transponders.carried().collect()
    }
}

/// Sensors that state identities, else sensors whose numbers and drones correspond one to one.
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
