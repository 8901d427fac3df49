//! Which tracks a reader wants, and how much of them: the same parameters for the picture and for the stream.

use std::collections::HashSet;
use std::sync::Arc;

use super::piece::{Piece, SOURCES};
use super::problem::Problem;
use super::query::Query;
use crate::config::Sensor;
use crate::picture::MAX_ACCURACY_M;
use crate::picture::TrackClass;
use fusion::integrity::State;

/// Rule of `bbox`.
const BBOX: &str = "four numbers lon_min,lat_min,lon_max,lat_max in degrees, ±180 and ±90; lat_min is not above \
                    lat_max; lon_min above lon_max spans the antimeridian";
/// Rule of `alt_min` and `alt_max`.
const ALTITUDE: &str = "a height above mean sea level in metres, -1000 to 100000";
/// Rule of `max_accuracy_m`.
const ACCURACY: &str = "a radius in metres, 1 to 10000";
/// Rule of `after`.
const AFTER: &str = "the next of the page before";
/// In `integrity`: tracks without a transponder, or without one that is judged.
pub const NOT_JUDGED: &str = "none";
/// In `include`: the competitors of a track's parts.
pub const COMPETITORS: &str = "competitors";
/// Most tracks in one answer.
const MOST: usize = 10_000;

/// A choice among tracks; the default is what readers get who ask for nothing else: all but vehicles on the
/// ground, and those that no sensor measured and that are known too poorly, [`MAX_ACCURACY_M`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filter {
    /// Longitude and latitude at least, at most.
    bbox: Option<[f64; 4]>,
    sources: Option<Vec<&'static str>>,
    classes: Option<Vec<TrackClass>>,
    /// `None` among them: without a transponder that is judged.
    integrity: Option<Vec<Option<State>>>,
    /// Indices of sensors.
    sensors: Option<Vec<usize>>,
    alt_min: Option<f64>,
    alt_max: Option<f64>,
    ids: Option<HashSet<String>>,
    max_accuracy_m: Option<f64>,
    limit: Option<usize>,
    /// Id behind which a page begins.
    after: Option<String>,
    competitors: bool,
}

/// A part of what a filter lets through.
#[derive(Debug)]
pub struct Page<T> {
    pub tracks: Vec<T>,
    /// How many the filter lets through in all.
    pub matched: usize,
    /// Id behind which the next page begins; `None` after the last one.
    pub next: Option<Arc<str>>,
}

impl Filter {
    /// As a request says, of these sensors.
    ///
    /// # Errors
    /// 400 for a parameter that breaks its rule.
    pub fn of(query: &Query, sensors: &[Sensor]) -> Result<Self, Problem> {
        let bbox = query.numbers::<4>("bbox", BBOX)?;
        let sane = |&[west, south, east, north]: &[f64; 4]| {
            west.abs() <= 180.0 && east.abs() <= 180.0 && -90.0 <= south && south <= north && north <= 90.0
        };
        if !bbox.as_ref().is_none_or(sane) {
            return Err(Problem::parameter("bbox", BBOX));
        }
        let sources = query.list(
            "source",
            |name| SOURCES.into_iter().find(|known| *known == name),
            || format!("of {}, separated by commas", SOURCES.join(", ")),
        )?;
        let classes = query.list(
            "class",
            |name| TrackClass::ALL.into_iter().find(|class| class.name() == name),
            || format!("of {}, separated by commas", TrackClass::ALL.map(TrackClass::name).join(", ")),
        )?;
        let state = |name: &str| match name {
            NOT_JUDGED => Some(None),
            _ => State::ALL.into_iter().find(|state| state.name() == name).map(Some),
        };
        let integrity = query.list("integrity", state, || {
            format!("of {}, {NOT_JUDGED}, separated by commas", State::ALL.map(State::name).join(", "))
        })?;
        let known = |name: &str| sensors.iter().position(|sensor| sensor.id == name);
        let names = || {
            let names: Vec<_> = sensors.iter().map(|sensor| sensor.id.as_str()).collect();
            format!("of the configured sensors {}, separated by commas", names.join(", "))
        };
        let sensors = query.list("sensor", known, names)?;
        let altitude = |name| query.value(name, ALTITUDE, |alt: &f64| (-1_000.0..=100_000.0).contains(alt));
        let within_m = |metres: &f64| (1.0..=10_000.0).contains(metres);
        let limit = query.value("limit", "a whole number, 1 to 10000", |limit| (1..=MOST).contains(limit))?;
        let extra = |name: &str| (name == COMPETITORS).then_some(());
        let include = query.list("include", extra, || format!("{COMPETITORS}, or nothing"))?;
        let id = |id: &str| (!id.is_empty()).then(|| id.to_owned());
        let ids = query.list("ids", id, || "ids of tracks, separated by commas".to_owned())?;
        Ok(Self {
            bbox,
            sources,
            classes,
            integrity,
            sensors,
            alt_min: altitude("alt_min")?,
            alt_max: altitude("alt_max")?,
            ids: ids.map(|ids| ids.into_iter().collect()),
            max_accuracy_m: query.value("max_accuracy_m", ACCURACY, within_m)?,
            limit,
            after: query.value("after", AFTER, |id: &String| !id.is_empty() && !id.contains(','))?,
            competitors: include.is_some(),
        })
    }

    /// Whether it is what readers get who ask for nothing else.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Whether a class is wanted: vehicles on the ground only where they are asked for.
    fn has_class(&self, class: TrackClass) -> bool {
        self.classes.as_ref().map_or(class != TrackClass::Vehicle, |classes| classes.contains(&class))
    }

    /// Whether the track is wanted. One whose height is unknown is within no height.
    pub fn wants(&self, piece: &Piece) -> bool {
        let max_accuracy_m = self.max_accuracy_m.unwrap_or(MAX_ACCURACY_M);
        piece.unmeasured_accuracy_m.is_none_or(|accuracy_m| accuracy_m <= max_accuracy_m)
            && self.bbox.is_none_or(|bbox| within(bbox, piece.lng, piece.lat))
            && self.sources.as_ref().is_none_or(|sources| sources.contains(&piece.source))
            && self.has_class(piece.class)
            && self.integrity.as_ref().is_none_or(|states| states.contains(&piece.integrity))
            && self
                .sensors
                .as_ref()
                .is_none_or(|wanted| piece.sensors().any(|sensor| wanted.contains(&sensor)))
            && self.alt_min.is_none_or(|least| piece.alt_msl.is_some_and(|alt| alt >= least))
            && self.alt_max.is_none_or(|most| piece.alt_msl.is_some_and(|alt| alt <= most))
            && self.ids.as_ref().is_none_or(|ids| ids.contains(&*piece.id))
    }

    /// Whether competitors are listed.
    pub fn competitors(&self) -> bool {
        self.competitors
    }

    /// Whether news of that sensor is wanted.
    pub fn wants_sensor(&self, index: usize) -> bool {
        self.sensors.as_ref().is_none_or(|wanted| wanted.contains(&index))
    }

    /// The page of the wanted ones that is asked for. Pages are in the order of ids, which lasts from slot to slot: whoever turns
    /// them sees each track once that is there all the while.
    pub fn page<T>(&self, tracks: impl Iterator<Item = T>, piece: impl Fn(&T) -> &Piece) -> Page<T> {
        let mut tracks: Vec<T> = tracks.filter(|track| self.wants(piece(track))).collect();
        let matched = tracks.len();
        if self.limit.is_some() || self.after.is_some() {
            tracks.sort_unstable_by(|a, b| piece(a).id.cmp(&piece(b).id));
        }
        if let Some(after) = &self.after {
            tracks.drain(..tracks.partition_point(|track| *piece(track).id <= **after));
        }
        let limit = self.limit.unwrap_or(MOST);
        let is_last = tracks.len() <= limit;
        tracks.truncate(limit);
        let next = tracks.last().filter(|_| !is_last).map(|last| piece(last).id.clone());
        Page { tracks, matched, next }
    }
}

/// A box whose west is east of its east spans the antimeridian.
fn within([west, south, east, north]: [f64; 4], lng: f64, lat: f64) -> bool {
    let across = west > east;
    (south..=north).contains(&lat)
        && if across { lng >= west || lng <= east } else { (west..=east).contains(&lng) }
}

#[cfg(test)]
mod tests {
    use super::within;

    #[test]
    fn a_box_may_span_the_antimeridian() {
        let fiji = [177.0, -20.0, -178.0, -15.0];
        for (lng, lat, inside) in [
            (179.0, -17.0, true),
            (-179.0, -17.0, true),
            (180.0, -17.0, true),
            (-180.0, -17.0, true),
            (176.9, -17.0, false),
            (-177.9, -17.0, false),
            (0.0, -17.0, false),
            (179.0, -14.0, false),
        ] {
            assert_eq!(within(fiji, lng, lat), inside, "{lng} {lat}");
        }
        assert!(within([-1.0, 50.0, 1.0, 53.0], 0.0, 53.0));
        assert!(!within([-1.0, 50.0, 1.0, 53.0], 1.1, 52.0));
    }
}
