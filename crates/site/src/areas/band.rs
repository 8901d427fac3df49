//! Floors and ceilings.

use super::member::Member;

/// Metres in a foot, exactly.
const FOOT_M: f64 = 0.3048;
/// The number that authorities write for "no upper limit", in metres and in feet.
const UNLIMITED: f64 = 99_999.0;

/// A height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Level {
    /// Metres above mean sea level.
    Amsl(f64),
    /// Metres above the WGS-84 ellipsoid.
    Ellipsoidal(f64),
}

impl Level {
    /// The height in metres above mean sea level. `undulation_m`: height of the geoid above the ellipsoid.
    pub fn amsl_m(self, undulation_m: f64) -> f64 {
        match self {
            Self::Amsl(metres) => metres,
            Self::Ellipsoidal(metres) => metres - undulation_m,
        }
    }
}

/// The heights at which an area applies. Without a floor it begins at the ground; without a ceiling it has no upper limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Band {
    /// Lowest height.
    pub floor: Option<Level>,
    /// Highest height.
    pub ceiling: Option<Level>,
}

/// A [`Band`] in metres above mean sea level.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BandAmsl {
    /// Lowest height.
    pub floor_m: Option<f64>,
    /// Highest height.
    pub ceiling_m: Option<f64>,
}

impl Band {
    /// The heights between two levels, in metres above mean sea level.
    pub fn amsl(floor_m: Option<f64>, ceiling_m: Option<f64>) -> Self {
        Self { floor: floor_m.map(Level::Amsl), ceiling: ceiling_m.map(Level::Amsl) }
    }

    /// Whether there is a floor or a ceiling.
    pub fn is_limited(&self) -> bool {
        self.floor.is_some() || self.ceiling.is_some()
    }

    /// The heights above mean sea level. `undulation_m`: height of the geoid above the ellipsoid.
    pub fn above_sea(&self, undulation_m: f64) -> BandAmsl {
        let metres = |level: Option<Level>| level.map(|level| level.amsl_m(undulation_m));
        BandAmsl { floor_m: metres(self.floor), ceiling_m: metres(self.ceiling) }
    }
}

impl BandAmsl {
    /// Whether the altitude is between floor and ceiling, or on one of them. An unknown altitude counts as inside.
    pub fn contains(&self, altitude_amsl_m: Option<f64>) -> bool {
        altitude_amsl_m.is_none_or(|altitude_m| {
            self.floor_m.is_none_or(|floor_m| floor_m <= altitude_m)
                && self.ceiling_m.is_none_or(|ceiling_m| altitude_m <= ceiling_m)
        })
    }

    /// The times, in seconds from now, between which an aircraft is in the band within the horizon; `climb` in metres per second.
    pub(super) fn within(
        &self,
        altitude_amsl_m: Option<f64>,
        climb: f64,
        horizon_s: f64,
    ) -> Option<(f64, f64)> {
        let Some(altitude_m) = altitude_amsl_m else { return Some((0.0, horizon_s)) };
        if climb == 0.0 {
            return self.contains(altitude_amsl_m).then_some((0.0, horizon_s));
        }
        let at = |limit_m: Option<f64>| limit_m.map(|limit_m| (limit_m - altitude_m) / climb);
        let (first, last) = match climb > 0.0 {
            true => (self.floor_m, self.ceiling_m),
            false => (self.ceiling_m, self.floor_m),
        };
        let from_s = at(first).map_or(0.0, |from_s| from_s.max(0.0));
        let to_s = at(last).map_or(horizon_s, |to_s| to_s.min(horizon_s));
        (from_s <= to_s).then_some((from_s, to_s))
    }
}

/// Names of the members that limit a volume in height.
pub(super) struct Names {
    pub(super) lower: &'static str,
    pub(super) lower_reference: &'static str,
    pub(super) upper: &'static str,
    pub(super) upper_reference: &'static str,
    pub(super) unit: &'static str,
}

/// Reads the heights of a volume. `ground_m`: height of the ground above mean sea level, if known.
pub(super) fn read(volume: &Member<'_>, names: &Names, ground_m: Option<f64>) -> Result<Band, String> {
    let unit = volume.get(names.unit);
    let metres = match &unit {
        None => 1.0,
        Some(unit) => match unit.text()?.to_ascii_lowercase().as_str() {
            "m" => 1.0,
            "ft" => FOOT_M,
            // Flight levels are refused, too: their height above the sea depends on the air pressure.
            _ => return Err(unit.refused("units of heights are understood in m and ft")),
        },
    };
    let level = |value: &str, reference: &str, is_upper: bool| {
        let Some(member) = volume.get(value) else { return Ok(None) };
        let value = member.number()?;
        if is_upper && value >= UNLIMITED {
            return Ok(None);
        }
        let known = "understood are AMSL, AGL and WGS84";
        let reference = volume.need(reference, known)?;
        match (reference.text()?, ground_m) {
            ("AMSL", _) => Ok(Some(Level::Amsl(value * metres))),
            ("WGS84" | "WGS-84", _) => Ok(Some(Level::Ellipsoidal(value * metres))),
            // A floor at or below the ground is no limit.
            ("AGL", _) if !is_upper && value <= 0.0 => Ok(None),
            ("AGL", Some(ground_m)) => Ok(Some(Level::Amsl(value * metres + ground_m))),
            ("AGL", None) => Err(format!(
                "{}, and the height of the ground is not known; add ground_m = …, the metres that it is above mean sea \
                 level, to this [[areas]]",
                member.refused("it is counted from the ground (AGL)")
            )),
            _ => Err(reference.refused(known)),
        }
    };
    let band = Band {
        floor: level(names.lower, names.lower_reference, false)?,
        ceiling: level(names.upper, names.upper_reference, true)?,
    };
    let is_empty = match (band.floor, band.ceiling) {
        (Some(Level::Amsl(floor)), Some(Level::Amsl(ceiling)))
        | (Some(Level::Ellipsoidal(floor)), Some(Level::Ellipsoidal(ceiling))) => floor >= ceiling,
        _ => false,
    };
    let empty = || volume.refused("the upper limit has to be above the lower one");
    if is_empty { Err(empty()) } else { Ok(band) }
}
