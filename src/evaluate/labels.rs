//! Labels: which drone each plot and each transponder really was.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::{Range, RangeInclusive};

use fusion::time::Time;

/// A row of `labels.csv`: what one plot or one transponder report was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The time of the plot or report.
    pub time: Time,
    /// The id of the sensor in the configuration.
    pub sensor: String,
    /// The radar's track number (I048/161), or the service's number of the transponder.
    pub number: u32,
    /// The drone's id in the truth; `None`: no drone (a bird, clutter).
    pub id: Option<String>,
    /// Whether the radar's track had walked off its target.
    pub seduced: bool,
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
    /// By number: the drones that carry a transponder of it.
    transponders: BTreeMap<u32, BTreeSet<Option<String>>>,
}

impl Labels {
    /// Labels whose transponder receivers are inferred: a sensor is taken for a receiver if its numbers and drones are one
    /// to one over the whole file, since a transponder stays on its drone while a radar also numbers birds and new tracks.
    /// A radar that never does is taken for a receiver, too; where two sensors then disagree, the labels are silent.
    pub fn new(rows: Vec<Label>) -> Self {
        let receivers = receivers(&rows);
        Self::with_receivers(rows, &receivers)
    }

    /// Labels with known transponder receivers, by sensor id; all other sensors are radars.
    pub fn with_receivers(rows: Vec<Label>, receivers: &BTreeSet<String>) -> Self {
        let mut labels = Self { rows, receivers: receivers.clone(), ..Self::default() };
        for (place, row) in labels.rows.iter().enumerate() {
            if receivers.contains(&row.sensor) {
                labels.transponders.entry(row.number).or_default().insert(row.id.clone());
            } else {
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

    /// Who carries the transponder with this number; `None` where labels are silent or receivers disagree.
    pub fn transponder(&self, number: u32) -> Option<Attribution<'_>> {
        let ids = self.transponders.get(&number)?;
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
        self.rows.iter().filter(move |row| row.number == number && self.receivers.contains(&row.sensor))
    }

    /// Ids of the drones that carry a transponder.
    pub fn equipped(&self) -> BTreeSet<&str> {
        self.transponders.values().flatten().flatten().map(String::as_str).collect()
    }
}

/// The sensors whose numbers and drones are one to one.
fn receivers(rows: &[Label]) -> BTreeSet<String> {
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
mod tests {
    use super::*;

    fn label(time: i64, sensor: &str, number: u32, id: &str, seduced: bool) -> Label {
        let id = (!id.is_empty()).then(|| id.to_owned());
        Label { time: Time::from_nanos(time), sensor: sensor.to_owned(), number, id, seduced }
    }

    fn span(from: i64, until: i64) -> Range<Time> {
        Time::from_nanos(from)..Time::from_nanos(until)
    }

    fn told(id: Option<&str>, seduced: bool) -> Option<Attribution<'_>> {
        Some(Attribution { id, seduced })
    }

    #[test]
    fn the_latest_plot_in_the_span_tells() {
        let labels = Labels::new(vec![
            label(14, "radar", 5, "B", true),
            label(10, "radar", 5, "A", false),
            label(14, "radar", 5, "", false),
            label(20, "radar", 5, "C", false),
        ]);
        assert_eq!(labels.radar_track(5, None, &span(10, 14)), told(Some("A"), false));
        assert_eq!(labels.radar_track(5, None, &span(10, 20)), told(None, false), "of one time the last");
        assert_eq!(labels.radar_track(5, Some("radar"), &span(20, 30)), told(Some("C"), false));
        assert_eq!(labels.radar_track(5, Some("other"), &span(20, 30)), None);
        assert_eq!(labels.radar_track(5, None, &span(15, 20)), None);
        assert_eq!(labels.radar_track(6, None, &span(10, 30)), None);
    }

    #[test]
    fn where_there_is_no_plot_those_beside_tell() {
        let labels = Labels::new(vec![
            label(10, "radar", 5, "A", false),
            label(20, "radar", 5, "", false),
            label(21, "radar", 6, "A", false),
        ]);
        let near = |time, before_ns, after_ns| {
            let span = Time::from_nanos(time - before_ns)..=Time::from_nanos(time + after_ns);
            labels.radar_track_near(5, None, Time::from_nanos(time), &span)
        };
        assert_eq!(near(8, 2, 2), told(Some("A"), false), "before it began");
        assert_eq!(near(14, 5, 5), told(Some("A"), false));
        assert_eq!(near(16, 5, 5), told(None, false));
        assert_eq!(near(15, 5, 5), None, "of one that was another's");
        assert_eq!(near(15, 5, 4), told(Some("A"), false), "who took part last");
        assert_eq!(near(23, 3, 0), told(None, false), "after its end");
        assert_eq!(near(24, 3, 9), None);
        assert_eq!(near(7, 9, 2), None);
    }

    #[test]
    fn radars_that_disagree_leave_it_open() {
        let rows = vec![
            label(1, "east", 5, "A", false),
            label(1, "west", 5, "", false),
            label(2, "east", 6, "A", false),
            label(2, "west", 6, "A", false),
        ];
        let labels = Labels::with_receivers(rows, &BTreeSet::new());
        assert_eq!(labels.radar_track(5, None, &span(0, 2)), None);
        assert_eq!(labels.radar_track(5, Some("west"), &span(0, 2)), told(None, false));
        assert_eq!(labels.radar_track(6, None, &span(2, 3)), told(Some("A"), false));
    }

    #[test]
    fn a_receiver_is_the_sensor_whose_numbers_stay_on_their_drones() {
        let labels = Labels::new(vec![
            label(1, "squitter", 7, "A", false),
            label(2, "squitter", 7, "A", false),
            label(2, "squitter", 9, "B", false),
            label(1, "radar", 7, "B", false),
            label(2, "radar", 8, "B", false),
        ]);
        assert_eq!(labels.transponder(7), told(Some("A"), false));
        assert_eq!(labels.transponder(8), None);
        assert_eq!(labels.equipped(), BTreeSet::from(["A", "B"]));
        assert_eq!(labels.radar_track(7, None, &span(1, 2)), told(Some("B"), false));
    }

    #[test]
    fn receivers_that_disagree_leave_it_open() {
        let rows = vec![label(1, "one", 7, "A", false), label(1, "two", 7, "B", false)];
        assert_eq!(Labels::new(rows).transponder(7), None);
    }
}
