//! Selection of tracks and of their detail, with the same parameters for the picture and for the stream.

use std::collections::HashSet;
use std::sync::Arc;

use super::problem::Problem;
use super::query::Query;
use super::track_slice::{SOURCES, TrackSlice};
use fusion::integrity::State;
use picture::MAX_ACCURACY_M;
use picture::TrackClass;
use site::config::Sensor;

/// Rule for `bbox`, for error messages.
const BBOX: &str = "four numbers lon_min,lat_min,lon_max,lat_max in degrees, ±180 and ±90; lat_min is not above \
                    lat_max; lon_min above lon_max spans the antimeridian";
/// Rule for `alt_min` and `alt_max`.
const ALTITUDE: &str = "a height above mean sea level in metres, -1000 to 100000";
/// Rule for `max_accuracy_m`.
const ACCURACY: &str = "a radius in metres, 1 to 10000";
/// Rule for `after`.
const AFTER: &str = "the next of the page before";
/// Value of `integrity`: tracks without a transponder whose integrity is evaluated.
pub const NOT_JUDGED: &str = "none";
/// Value of `include`: the competing associations of a track's parts.
pub const COMPETITORS: &str = "competitors";
/// Maximum number of tracks in one answer.
const MOST: usize = 10_000;

/// A selection of tracks. The default leaves out vehicles on the ground, and tracks that no sensor measured and whose accuracy is
/// worse than [`MAX_ACCURACY_M`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackFilter {
    /// Minimum longitude and latitude, maximum longitude and latitude.
    bbox: Option<[f64; 4]>,
    sources: Option<Vec<&'static str>>,
    classes: Option<Vec<TrackClass>>,
    /// Wanted integrity states. `None` selects tracks without a transponder that is evaluated.
    integrity: Option<Vec<Option<State>>>,
    /// Indices of wanted sensors.
    sensors: Option<Vec<usize>>,
    alt_min: Option<f64>,
    alt_max: Option<f64>,
    ids: Option<HashSet<String>>,
    max_accuracy_m: Option<f64>,
    limit: Option<usize>,
    /// Id after which the page starts.
    after: Option<String>,
    competitors: bool,
}

/// Whether these are minimum longitude and latitude, then maximum longitude and latitude, in degrees.
pub fn is_box([west, south, east, north]: [f64; 4]) -> bool {
    west.abs() <= 180.0 && east.abs() <= 180.0 && -90.0 <= south && south <= north && north <= 90.0
}

/// A page of the selected tracks.
#[derive(Debug)]
pub struct SelectedPage<T> {
    pub tracks: Vec<T>,
    /// Total number of selected tracks.
    pub matched: usize,
    /// Id after which the next page starts; `None` after the last page.
    pub next: Option<Arc<str>>,
}

impl TrackFilter {
    /// Selection by the parameters of a request, with the given sensors.
    ///
    /// # Errors
    /// 400 if a parameter breaks its rule.
    pub fn of(query: &Query, sensors: &[Sensor]) -> Result<Self, Problem> {
        let bbox = query.numbers::<4>("bbox", BBOX)?;
        if !bbox.is_none_or(is_box) {
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

    /// Whether it is the default selection.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Whether a class is selected. Vehicles on the ground have to be asked for.
    fn has_class(&self, class: TrackClass) -> bool {
        self.classes.as_ref().map_or(class != TrackClass::Vehicle, |classes| classes.contains(&class))
    }

    /// Whether the track is selected. A track of unknown height is outside any range of heights.
    pub fn wants(&self, slice: &TrackSlice) -> bool {
        let max_accuracy_m = self.max_accuracy_m.unwrap_or(MAX_ACCURACY_M);
        slice.unmeasured_accuracy_m.is_none_or(|accuracy_m| accuracy_m <= max_accuracy_m)
            && self.bbox.is_none_or(|bbox| within(bbox, slice.lng, slice.lat))
            && self.sources.as_ref().is_none_or(|sources| sources.contains(&slice.source))
            && self.has_class(slice.class)
            && self.integrity.as_ref().is_none_or(|states| states.contains(&slice.integrity))
            && self
                .sensors
                .as_ref()
                .is_none_or(|wanted| slice.sensors().any(|sensor| wanted.contains(&sensor)))
            && self.alt_min.is_none_or(|least| slice.alt_msl.is_some_and(|alt| alt >= least))
            && self.alt_max.is_none_or(|most| slice.alt_msl.is_some_and(|alt| alt <= most))
            && self.ids.as_ref().is_none_or(|ids| ids.contains(&*slice.id))
    }

    /// Whether competing associations are listed.
    pub fn competitors(&self) -> bool {
        self.competitors
    }

    /// Whether events of the sensor are wanted.
    pub fn wants_sensor(&self, index: usize) -> bool {
        self.sensors.as_ref().is_none_or(|wanted| wanted.contains(&index))
    }

    /// The requested page of the selected tracks. Pages are in the order of ids, which does not change between slots: a client
    /// that reads all pages gets each track that exists all the time exactly once.
    pub fn page<T>(
        &self,
        tracks: impl Iterator<Item = T>,
        slice: impl Fn(&T) -> &TrackSlice,
    ) -> SelectedPage<T> {
        let mut tracks: Vec<T> = tracks.filter(|track| self.wants(slice(track))).collect();
        let matched = tracks.len();
        if self.limit.is_some() || self.after.is_some() {
            tracks.sort_unstable_by(|a, b| slice(a).id.cmp(&slice(b).id));
        }
        if let Some(after) = &self.after {
            tracks.drain(..tracks.partition_point(|track| *slice(track).id <= **after));
        }
        let limit = self.limit.unwrap_or(MOST);
        let is_last = tracks.len() <= limit;
        tracks.truncate(limit);
        let next = tracks.last().filter(|_| !is_last).map(|last| slice(last).id.clone());
        SelectedPage { tracks, matched, next }
    }
}

/// Whether a place is in the box. A box whose western limit is east of its eastern one spans the antimeridian.
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
