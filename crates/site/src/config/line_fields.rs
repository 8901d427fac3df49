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
        let (kind, allowed, identity_key, identity) = if is_radar {
            ("radar", &OF_RADARS[..], "track", &self.track)
        } else {
            ("transponder", &OF_TRANSPONDERS[..], "serial_number", &self.serial_number)
        };
        if let Some((key, _)) = self.named().find(|(key, _)| !allowed.contains(key)) {
            return Err(format!("a {kind} has no fields.{key}; remove it"));
        }
        let reader = FieldReader { is_csv: !columns.is_empty() };
        if reader.is_csv {
            let is_known = |text: &str| {
                let name = text.split_whitespace().next().unwrap_or_default();
                columns.iter().any(|column| column == name.trim_start_matches('-'))
            };
            if let Some((key, text)) = self.named().find(|(_, text)| !is_known(text)) {
                return Err(format!("fields.{key} = \"{text}\" names none of the columns"));
            }
        }
        let missing = |key: &str| format!("fields.{key} is missing: a {kind} needs it");
        let position = self.position(&reader, is_radar)?;
        let height = reader.read(&self.height, LENGTHS);
        self.check_height(&position)?;
        if !is_radar && height.is_none() {
            return Err(missing("height"));
        }
        let class = reader.read(&self.class, &[]);
        if class.is_some() == drone_classes.is_empty() {
            return Err("fields.class and drone_classes go together".to_owned());
        }
        if class.is_some() && self.probability.is_some() {
            return Err("remove class or probability".to_owned());
        }
        let velocity = match (reader.read(&self.speed, SPEEDS), reader.read(&self.course, ANGLES)) {
            (None, None) => None,
            (Some(speed), Some(course)) => Some((speed, course)),
            _ => return Err("speed and course go together".to_owned()),
        };
        Ok(LineMapping {
            columns: reader.is_csv.then(|| columns.to_vec()),
            time: reader.read(&self.time, TIMES),
            identity: reader.read(identity, &[]).ok_or_else(|| missing(identity_key))?,
            position,
            height,
            velocity,
            probability: reader.read(&self.probability, SHARES),
            class: class.map(|class| (class, drone_classes.to_vec())),
        })
    }

    /// The only form of a position that is named.
    fn position(&self, reader: &FieldReader, is_radar: bool) -> Result<LinePosition, String> {
        let length = |text| reader.read(text, LENGTHS);
        let angle = |text| reader.read(text, ANGLES);
        let polar = (length(&self.range), angle(&self.azimuth));
        let local = (length(&self.east), length(&self.north));
        let place = (angle(&self.latitude), angle(&self.longitude));
        let forms =
            [("range and azimuth", &polar), ("east and north", &local), ("latitude and longitude", &place)];
        let is_named = |(_, form): &&(&str, &(Option<LineField>, Option<LineField>))| **form != (None, None);
        let named: Vec<&str> = forms.iter().filter(is_named).map(|(name, _)| *name).collect();
        match named.as_slice() {
            [_] => {}
            [] if is_radar => {
                let forms = forms.map(|(name, _)| name).join(", or ");
                return Err(format!("a position is needed: {forms}"));
            }
            [] => return Err("a position is needed: latitude and longitude".to_owned()),
            several => {
                return Err(format!("a position is one of {}; remove the others", several.join(", ")));
            }
        }
        match (polar, local, place) {
            ((Some(range), Some(azimuth)), ..) => {
                Ok(LinePosition::Polar { range, azimuth, elevation: angle(&self.elevation) })
            }
            (_, (Some(east), Some(north)), _) => Ok(LinePosition::Local(east, north, length(&self.up))),
            (.., (Some(latitude), Some(longitude))) => Ok(LinePosition::Geodetic(latitude, longitude)),
            _ => Err(format!("a position needs both {}", named.join(""))),
        }
    }

    /// Reports a second height, and an elevation or `up` that does not go with the position.
    fn check_height(&self, position: &LinePosition) -> Result<(), String> {
        let is_polar = matches!(position, LinePosition::Polar { .. });
        let is_local = matches!(position, LinePosition::Local(..));
        let stray = match (&self.elevation, &self.up, &self.height) {
            (Some(_), ..) if !is_polar => "elevation, which goes with range",
            (_, Some(_), _) if !is_local => "up, which goes with east and north",
            (Some(_), _, Some(_)) => "height or elevation",
            (_, Some(_), Some(_)) => "height or up",
            _ => return Ok(()),
        };
        Err(format!("remove {stray}"))
    }
}

/// Reads the fields of one connection.
struct FieldReader {
    /// The names of columns may have dots.
    is_csv: bool,
}

impl FieldReader {
    fn read(&self, text: &Option<String>, units: Units) -> Option<LineField> {
        let mut field = LineField::new(text.as_deref()?, units)?;
        if self.is_csv {
            field.path = vec![field.path.join(".")];
        }
        Some(field)
    }
}
