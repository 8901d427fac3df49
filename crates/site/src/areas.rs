//! The areas of `[[areas]]`: polygons in GeoJSON (RFC 7946) and UAS zones (EUROCAE ED-318, ED-269), read once at the start.

mod alerting;
mod band;
mod crs;
mod ed269;
mod ed318;
mod entry;
mod file;
mod geojson;
mod hours;
mod member;
mod schedule;
mod shape;
mod zone;

use std::path::PathBuf;

use geo::orient::{Direction, Orient};
use geo::{MultiPolygon, Point};

use crate::config::{AlertArea, Area, AreaKind, Config, Sensor};
use fusion::time::Time;

pub use alerting::{AlertAreas, Entry, Presence, Visitor, severity};
pub use band::{Band, BandAmsl, Level};
pub use entry::Path;
pub use schedule::Schedule;
pub use shape::on_map;
pub use zone::{Format, Zone, ZoneKind};

use file::Contents;
use shape::Shape;
use zone::Reading;

/// Areas in which plots are dropped: roads, wind farms, fixed echoes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Masks(Vec<Shape>);

/// Areas in which a transponder can be received: the coverage of the receivers for which one is configured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeardAreas(Vec<Shape>);

/// A file of `[[areas]]` that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}", file.display())]
pub struct AreaError {
    /// Path of the file.
    pub file: PathBuf,
    /// The problem, and what a file of areas has to contain.
    pub problem: String,
}

/// All areas of a configuration, masks first, with their files as they were when read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Areas(Vec<(Area, Contents)>);

/// A part of an area, with the area and the zone that it belongs to.
#[derive(Clone, Debug)]
pub struct Part<'a> {
    /// The configuration of the area.
    pub area: &'a Area,
    /// The zone of the file.
    pub zone: &'a Zone,
    /// Outer ring counterclockwise, holes clockwise (RFC 7946).
    pub polygon: MultiPolygon,
    /// The heights at which this part applies.
    pub band: Band,
}

impl Areas {
    /// Reads the files.
    ///
    /// # Errors
    /// A file cannot be read, or contains something that is not understood.
    pub fn load(areas: &[Area]) -> Result<Self, AreaError> {
        let mut areas: Vec<(Area, Contents)> =
            areas.iter().map(|area| Ok((area.clone(), read(area)?))).collect::<Result<_, _>>()?;
        areas.sort_by_key(|(area, _)| area.kind != AreaKind::Mask);
        Ok(Self(areas))
    }

    /// Reads one file whose text is `text`.
    ///
    /// # Errors
    /// The text contains something that is not understood.
    pub fn parse(text: &str, area: Area) -> Result<Self, AreaError> {
        let contents =
            contents(text, &area).map_err(|problem| AreaError { file: area.file.clone(), problem })?;
        Ok(Self(vec![(area, contents)]))
    }

    /// The areas of kind `mask`.
    pub fn masks(&self) -> Masks {
        Masks(self.shapes(|area| area.kind == AreaKind::Mask))
    }

    /// The areas of kind `alert`.
    pub fn alerts(&self) -> AlertAreas {
        AlertAreas::of(self.zones().filter_map(|(area, zone)| Some((area.alert()?, zone))))
    }

    /// The areas of kind `alert` of these and of `others`.
    pub fn alerts_with<'a>(&'a self, others: impl Iterator<Item = &'a Self>) -> AlertAreas {
        let zones = self.zones().chain(others.flat_map(Self::zones));
        AlertAreas::of(zones.filter_map(|(area, zone)| Some((area.alert()?, zone))))
    }

    /// The areas of kind `coverage` of transponder receivers.
    pub fn heard(&self, config: &Config) -> HeardAreas {
        HeardAreas(self.shapes(|area| is_heard(area, config)))
    }

    /// Each zone with the configuration of its area.
    pub fn zones(&self) -> impl Iterator<Item = (&Area, &Zone)> {
        self.0.iter().flat_map(|(area, contents)| contents.zones.iter().map(move |zone| (area, zone)))
    }

    /// Each part of each zone.
    pub fn parts(&self) -> impl Iterator<Item = Part<'_>> {
        self.zones().flat_map(|(area, zone)| {
            zone.volumes.iter().map(move |volume| Part {
                area,
                zone,
                polygon: volume.shape.polygon.orient(Direction::Default),
                band: volume.band,
            })
        })
    }

    /// The configurations of the areas.
    pub fn configured(&self) -> impl Iterator<Item = &Area> {
        self.0.iter().map(|(area, _)| area)
    }

    /// Warnings about files whose validity, as stated by their publisher, has ended.
    pub fn warnings(&self, now: Time) -> Vec<String> {
        let replaced = self.0.iter().filter_map(|(area, contents)| {
            let valid_to = contents.valid_to.filter(|&valid_to| valid_to <= now)?;
            let file = area.file.display();
            Some(format!(
                "{file}: was valid up to {valid_to}; its zones are in force all the same: get the present one"
            ))
        });
        replaced.collect()
    }

    /// These areas with the masks replaced.
    #[must_use]
    pub fn with_masks_of(&self, other: &Self) -> Self {
        let masks = other.0.iter().filter(|(area, _)| area.kind == AreaKind::Mask);
        let others = self.0.iter().filter(|(area, _)| area.kind != AreaKind::Mask);
        Self(masks.chain(others).cloned().collect())
    }

    fn shapes(&self, is_wanted: impl Fn(&Area) -> bool) -> Vec<Shape> {
        let zones = self.zones().filter(|(area, _)| is_wanted(area));
        zones.flat_map(|(_, zone)| zone.volumes.iter().map(|volume| volume.shape.clone())).collect()
    }
}

impl AlertAreas {
    /// Loads the areas of kind `alert`.
    ///
    /// # Errors
    /// A file cannot be read, or contains something that is not understood.
    pub fn load(areas: &[Area]) -> Result<Self, AreaError> {
        Ok(Areas::load(&only(areas, |area| area.alert().is_some()))?.alerts())
    }
}

impl HeardAreas {
    /// Loads the areas of kind `coverage` of transponder receivers.
    ///
    /// # Errors
    /// A file cannot be read, or contains something that is not understood.
    pub fn load(config: &Config) -> Result<Self, AreaError> {
        Ok(Areas::load(&only(&config.areas, |area| is_heard(area, config)))?.heard(config))
    }

    /// Whether there are no areas.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a position, in degrees, is inside an area or on its edge.
    pub fn contain(&self, longitude_deg: f64, latitude_deg: f64) -> bool {
        let place = Point::new(longitude_deg, latitude_deg);
        self.0.iter().any(|area| area.contains(&place))
    }
}

fn is_heard(area: &Area, config: &Config) -> bool {
    let AreaKind::Coverage { sensor: id } = &area.kind else { return false };
    let of_receiver = |sensor: &Sensor| sensor.id == *id && sensor.kind.is_transponder();
    config.sensors.iter().any(of_receiver)
}

impl Masks {
    /// Loads the areas of kind `mask`.
    ///
    /// # Errors
    /// A file cannot be read, or contains something that is not understood.
    pub fn load(areas: &[Area]) -> Result<Self, AreaError> {
        Ok(Areas::load(&only(areas, |area| area.kind == AreaKind::Mask))?.masks())
    }

    /// Whether there are no masks; positions then need not be calculated.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a position, in degrees, is inside a mask or on its edge. Edges are straight in longitude and latitude.
    pub fn contain(&self, longitude_deg: f64, latitude_deg: f64) -> bool {
        let place = Point::new(longitude_deg, latitude_deg);
        self.0.iter().any(|mask| mask.contains(&place))
    }
}

fn only(areas: &[Area], is_wanted: impl Fn(&Area) -> bool) -> Vec<Area> {
    areas.iter().filter(|area| is_wanted(area)).cloned().collect()
}

fn read(area: &Area) -> Result<Contents, AreaError> {
    let error = |problem: String| AreaError { file: area.file.clone(), problem };
    #[expect(clippy::disallowed_methods, reason = "the one place that reads areas")]
    let text =
        std::fs::read_to_string(&area.file).map_err(|cause| error(format!("cannot be read: {cause}")))?;
    contents(&text, area).map_err(error)
}

fn contents(text: &str, area: &Area) -> Result<Contents, String> {
    // The name of the file without its directories, which are not to be published.
    let stem = area.file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    // Only alert areas may be limited in height or time, so the ground height and the time zone do not matter for others.
    let unlimited =
        AlertArea { ground_m: Some(0.0), time_zone: Some("UTC".to_owned()), ..AlertArea::default() };
    let contents = file::read(text, &Reading::new(stem, area.alert().unwrap_or(&unlimited)))?;
    let limited = contents.zones.iter().filter(|zone| zone.is_limited()).map(Zone::label).next();
    match limited.filter(|_| area.alert().is_none()) {
        Some(label) => Err(format!(
            "the zone {label} holds at some heights or times only, and an area of kind = \"{}\" holds always; remove the \
             limits from a copy of the file, where that is wanted",
            area.kind.name()
        )),
        None => Ok(contents),
    }
}

#[cfg(test)]
mod tests;
