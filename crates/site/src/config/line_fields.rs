//! `fields` of a connection: where the lines of a sensor that sends text have their values.

use tables::kinds::text;
use tables::section;
use tables::table::absent;

section! {
    /// Values of a `"json"` or `"csv"` connection, each the name of a member or column, and its unit if it is not the first of
    /// those listed: `height = "alt ft"`. Dots lead to members of members: `"position.alt"`. `-` before the name changes the
    /// sign.
    #[derive(Eq)]
    LineFields {
        /// Time of the measurement: text in RFC 3339, or a number since 1970.
        time: Option<String> = absent("the time of reception"), text("a name, and s, ms, us or ns", LineField::is_time);
        /// Number or name of the radar's track.
        track: Option<String> = absent("a radar needs it"), text("a name", LineField::is_name);
        /// Serial number of a transponder's drone.
        serial_number: Option<String> = absent("a transponder needs it"), text("a name", LineField::is_name);
        /// Slant range from the radar.
        range: Option<String> = absent("none"), text("a name, and m, km, ft or NM", LineField::is_length);
        /// Azimuth from the radar, clockwise from north.
        azimuth: Option<String> = absent("none"), text("a name, and deg or rad", LineField::is_angle);
        /// Elevation from the radar, up from the horizon.
        elevation: Option<String> = absent("none"), text("a name, and deg or rad", LineField::is_angle);
        /// Distance to the east of the radar.
        east: Option<String> = absent("none"), text("a name, and m, km, ft or NM", LineField::is_length);
        /// Distance to the north of the radar.
        north: Option<String> = absent("none"), text("a name, and m, km, ft or NM", LineField::is_length);
        /// Distance above the radar.
        up: Option<String> = absent("none"), text("a name, and m, km, ft or NM", LineField::is_length);
        /// WGS-84 latitude.
        latitude: Option<String> = absent("none"), text("a name, and deg or rad", LineField::is_angle);
        /// WGS-84 longitude.
        longitude: Option<String> = absent("none"), text("a name, and deg or rad", LineField::is_angle);
        /// Height above mean sea level.
        height: Option<String> = absent("none"), text("a name, and m, km, ft or NM", LineField::is_length);
        /// Speed over ground.
        speed: Option<String> = absent("none"), text("a name, and m/s, km/h or kt", LineField::is_speed);
        /// Course over ground, clockwise from north; together with `speed`.
        course: Option<String> = absent("none"), text("a name, and deg or rad", LineField::is_angle);
        /// Probability that a radar's track is a drone.
        probability: Option<String> = absent("none"), text("a name, and 1 or %", LineField::is_share);
        /// Class of a radar's track, instead of a probability: text that `drone_classes` lists, or does not.
        class: Option<String> = absent("none"), text("a name", LineField::is_name);
    }
}

/// Units and their size in the first of them.
type Units = &'static [(&'static str, f64)];

/// Units of time since 1970.
const TIMES: Units = &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)];
const LENGTHS: Units = &[("m", 1.0), ("km", 1000.0), ("ft", 0.3048), ("NM", 1852.0)];
const ANGLES: Units = &[("deg", 1.0), ("rad", 180.0 / std::f64::consts::PI)];
const SPEEDS: Units = &[("m/s", 1.0), ("km/h", 1.0 / 3.6), ("kt", 1852.0 / 3600.0)];
const SHARES: Units = &[("1", 1.0), ("%", 0.01)];

/// A value of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct LineField {
    /// Names of the member and of its parents, outermost first; of a column one name.
    pub path: Vec<String>,
    /// Number by which the value is multiplied to be in the usual unit: s, m, degrees, m/s, or 1.
    pub factor: f64,
}

impl LineField {
    fn new(text: &str, units: Units) -> Option<Self> {
        let mut words = text.split_whitespace();
        let name = words.next()?;
        let unit = match words.next() {
            Some(unit) => units.iter().find(|(known, _)| *known == unit)?.1,
            None => 1.0,
        };
        let (name, sign) = name.strip_prefix('-').map_or((name, 1.0), |rest| (rest, -1.0));
        let path: Vec<String> = name.split('.').map(str::to_owned).collect();
        let is_sound = words.next().is_none() && path.iter().all(|part| !part.is_empty());
        is_sound.then_some(Self { path, factor: sign * unit })
    }

    fn is_time(text: &str) -> bool {
        Self::new(text, TIMES).is_some_and(|field| field.factor > 0.0)
    }

    fn is_length(text: &str) -> bool {
        Self::new(text, LENGTHS).is_some()
    }

    fn is_angle(text: &str) -> bool {
        Self::new(text, ANGLES).is_some()
    }

    fn is_speed(text: &str) -> bool {
        Self::new(text, SPEEDS).is_some()
    }

    fn is_share(text: &str) -> bool {
        Self::new(text, SHARES).is_some_and(|field| field.factor > 0.0)
    }

    fn is_name(text: &str) -> bool {
        Self::new(text, &[]).is_some_and(|field| field.factor > 0.0)
    }
}

/// How a line states a position.
#[derive(Clone, Debug, PartialEq)]
pub enum LinePosition {
    /// From the radar: slant range and azimuth.
    Polar {
        /// Slant range.
        range: LineField,
        /// Azimuth, clockwise from north.
        azimuth: LineField,
        /// Elevation, if it is measured.
        elevation: Option<LineField>,
    },
    /// From the radar: east, north and, if it is measured, up.
    Local(LineField, LineField, Option<LineField>),
    /// Latitude and longitude.
    Geodetic(LineField, LineField),
}

/// The values of a line, by their names in it. Units: s, m, degrees, m/s, 1.
#[derive(Clone, Debug, PartialEq)]
pub struct LineMapping {
    /// Names of the columns of CSV; `None`: lines are JSON objects.
    pub columns: Option<Vec<String>>,
    /// Time of the measurement.
    pub time: Option<LineField>,
    /// Track of a radar, or serial number of a transponder.
    pub identity: LineField,
    /// Position.
    pub position: LinePosition,
    /// Height above mean sea level.
    pub height: Option<LineField>,
    /// Speed and course over ground.
    pub velocity: Option<(LineField, LineField)>,
    /// Probability of a drone.
    pub probability: Option<LineField>,
    /// Class, and those that are drones.
    pub class: Option<(LineField, Vec<String>)>,
}

/// Fields that a radar, and that a transponder may have.
const OF_RADARS: [&str; 15] = [
    "time",
    "track",
    "range",
    "azimuth",
    "elevation",
    "east",
    "north",
    "up",
    "latitude",
    "longitude",
    "height",
    "speed",
    "course",
    "probability",
    "class",
];
const OF_TRANSPONDERS: [&str; 7] =
    ["time", "serial_number", "latitude", "longitude", "height", "speed", "course"];

impl LineFields {
    /// The fields that are named, with their keys.
    fn named(&self) -> impl Iterator<Item = (&'static str, &str)> {
        [
            ("time", &self.time),
            ("track", &self.track),
            ("serial_number", &self.serial_number),
            ("range", &self.range),
            ("azimuth", &self.azimuth),
            ("elevation", &self.elevation),
            ("east", &self.east),
            ("north", &self.north),
            ("up", &self.up),
            ("latitude", &self.latitude),
            ("longitude", &self.longitude),
            ("height", &self.height),
            ("speed", &self.speed),
            ("course", &self.course),
            ("probability", &self.probability),
            ("class", &self.class),
        ]
        .into_iter()
        .filter_map(|(key, text)| Some((key, text.as_deref()?)))
    }
}

impl LineFields {
    /// Where lines have their values. `columns` are those of CSV, empty for JSON; `drone_classes` the values of `class` that are
    /// drones.
    ///
    /// # Errors
    /// What is missing or too much for a radar or a transponder, for the operator.
    pub(super) fn mapping(
        &self,
        columns: &[String],
        drone_classes: &[String],
        is_radar: bool,
    ) -> Result<LineMapping, String> {
        let fields = self;
        let allowed: &[&str] = if is_radar { &OF_RADARS } else { &OF_TRANSPONDERS };
        let kind = if is_radar { "radar" } else { "transponder" };
        if let Some((key, _)) = fields.named().find(|(key, _)| !allowed.contains(key)) {
            return Err(format!("a {kind} has no fields.{key}; remove it"));
        }
        let columns = (!columns.is_empty()).then(|| columns.to_vec());
        if let Some(columns) = &columns {
            let is_known = |text: &str| {
                LineField::new(text.split_whitespace().next().unwrap_or_default(), &[])
                    .is_some_and(|field| columns.contains(&field.path.join(".")))
            };
            if let Some((key, text)) = fields.named().find(|(_, text)| !is_known(text)) {
                return Err(format!("fields.{key} = \"{text}\" names none of the columns"));
            }
        }
        let read = |text: &Option<String>, units| {
            let mut field = LineField::new(text.as_deref()?, units)?;
            if columns.is_some() {
                field.path = vec![field.path.join(".")];
            }
            Some(field)
        };
        let length = |text| read(text, LENGTHS);
        let angle = |text| read(text, ANGLES);
        let polar = length(&fields.range).zip(angle(&fields.azimuth));
        let local = length(&fields.east).zip(length(&fields.north));
        let place = angle(&fields.latitude).zip(angle(&fields.longitude));
        let height = length(&fields.height);
        let forms = [
            (fields.range.is_some() || fields.azimuth.is_some(), "range and azimuth"),
            (fields.east.is_some() || fields.north.is_some(), "east and north"),
            (fields.latitude.is_some() || fields.longitude.is_some(), "latitude and longitude"),
        ];
        let stated: Vec<&str> =
            forms.iter().filter(|(is_stated, _)| *is_stated).map(|(_, name)| *name).collect();
        let position = match (stated.as_slice(), polar, local, place) {
            ([_], Some((range, azimuth)), ..) => {
                LinePosition::Polar { range, azimuth, elevation: angle(&fields.elevation) }
            }
            ([_], _, Some((east, north)), _) => LinePosition::Local(east, north, length(&fields.up)),
            ([_], .., Some((latitude, longitude))) => LinePosition::Geodetic(latitude, longitude),
            ([], ..) if is_radar => {
                return Err(
                    "a position is needed: range and azimuth, east and north, or latitude and longitude"
                        .to_owned(),
                );
            }
            ([], ..) => return Err("a position is needed: latitude and longitude".to_owned()),
            ([one], ..) => return Err(format!("a position needs both {one}")),
            (several, ..) => {
                return Err(format!("a position is one of {}; remove the others", several.join(", ")));
            }
        };
        let stray = match &position {
            LinePosition::Polar { elevation: Some(_), .. } if height.is_some() => Some("height or elevation"),
            LinePosition::Local(_, _, Some(_)) if height.is_some() => Some("height or up"),
            _ if fields.elevation.is_some() && !matches!(position, LinePosition::Polar { .. }) => {
                Some("elevation, which goes with range")
            }
            _ if fields.up.is_some() && !matches!(position, LinePosition::Local(..)) => {
                Some("up, which goes with east and north")
            }
            _ => None,
        };
        if let Some(stray) = stray {
            return Err(format!("remove {stray}"));
        }
        let (identity, name) =
            if is_radar { (&fields.track, "track") } else { (&fields.serial_number, "serial_number") };
        let identity =
            read(identity, &[]).ok_or_else(|| format!("fields.{name} is missing: a {kind} needs it"))?;
        if !is_radar && height.is_none() {
            return Err("fields.height is missing: a transponder needs it".to_owned());
        }
        let velocity = match (read(&fields.speed, SPEEDS), angle(&fields.course)) {
            (None, None) => None,
            (Some(speed), Some(course)) => Some((speed, course)),
            _ => return Err("speed and course go together".to_owned()),
        };
        let class = read(&fields.class, &[]);
        if class.is_some() == drone_classes.is_empty() {
            return Err("fields.class and drone_classes go together".to_owned());
        }
        if class.is_some() && fields.probability.is_some() {
            return Err("remove class or probability".to_owned());
        }
        let (time, probability) = (read(&fields.time, TIMES), read(&fields.probability, SHARES));
        Ok(LineMapping {
            columns,
            time,
            identity,
            position,
            height,
            velocity,
            probability,
            class: class.map(|class| (class, drone_classes.to_vec())),
        })
    }
}
