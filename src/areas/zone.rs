//! What is known of an area, whichever the file it is from.

use jiff::tz::TimeZone;

use super::band::{Band, BandAmsl};
use super::member::Member;
use super::schedule::Schedule;
use super::shape::Shape;
use crate::config::AlertArea;

/// An area as its file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// What people call it.
    pub name: String,
    /// What its authority calls it.
    pub identifier: Option<String>,
    /// `None`: a polygon of which nothing is said.
    pub kind: Option<ZoneKind>,
    /// What of it is in force under which conditions, in the authority's words.
    pub conditions: Option<String>,
    /// When it applies.
    pub schedule: Schedule,
    /// What it was read from.
    pub format: Format,
    /// Where it is: in any of these.
    pub(super) volumes: Vec<Volume>,
}

/// A part of an area.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Volume {
    pub(super) shape: Shape,
    pub(super) band: Band,
}

impl Zone {
    /// Its name, with its identifier where that says more.
    pub fn label(&self) -> String {
        match &self.identifier {
            Some(identifier) if *identifier != self.name => format!("{} ({identifier})", self.name),
            _ => self.name.clone(),
        }
    }

    /// The heights from the lowest of its parts to the highest, where the geoid is that far above the ellipsoid.
    pub fn band_above_sea(&self, undulation_m: f64) -> BandAmsl {
        let bands = || self.volumes.iter().map(|volume| volume.band.above_sea(undulation_m));
        let floors: Option<Vec<f64>> = bands().map(|band| band.floor_m).collect();
        let ceilings: Option<Vec<f64>> = bands().map(|band| band.ceiling_m).collect();
        BandAmsl {
            floor_m: floors.and_then(|floors| floors.into_iter().min_by(f64::total_cmp)),
            ceiling_m: ceilings.and_then(|ceilings| ceilings.into_iter().max_by(f64::total_cmp)),
        }
    }

    /// Whether it leaves out any height or time.
    pub(super) fn is_limited(&self) -> bool {
        !self.schedule.is_always() || self.volumes.iter().any(|volume| volume.band.is_limited())
    }
}

/// What holds inside a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneKind {
    /// Nobody flies.
    Prohibited,
    /// Who has an authorisation flies.
    Authorisation,
    /// Who keeps to conditions flies.
    Conditional,
    /// Who uses the services of its U-space flies.
    USpace,
    /// Everybody flies.
    NoRestriction,
}

fusion::interface_names!(ZoneKind {
    Prohibited = "prohibited",
    Authorisation = "authorisation",
    Conditional = "conditional",
    USpace = "u-space",
    NoRestriction = "no-restriction",
});

impl ZoneKind {
    /// As authorities write it.
    pub(super) fn of(text: &str) -> Option<Self> {
        match text {
            "PROHIBITED" => Some(Self::Prohibited),
            "REQ_AUTHORIZATION" | "REQ_AUTHORISATION" => Some(Self::Authorisation),
            "CONDITIONAL" => Some(Self::Conditional),
            "USPACE" => Some(Self::USpace),
            "NO_RESTRICTION" => Some(Self::NoRestriction),
            _ => None,
        }
    }

    pub(super) fn read(member: &Member<'_>) -> Result<Self, String> {
        const UNDERSTOOD: &str = "understood are PROHIBITED, REQ_AUTHORIZATION, REQ_AUTHORISATION, CONDITIONAL, USPACE and NO_RESTRICTION";
        Self::of(member.text()?).ok_or_else(|| member.refused(UNDERSTOOD))
    }
}

/// Formats of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Polygons, RFC 7946.
    GeoJson,
    /// UAS zones of EUROCAE ED-318, which are GeoJSON with more members.
    Ed318,
    /// UAS zones of EUROCAE ED-269.
    Ed269,
}

fusion::interface_names!(Format { GeoJson = "geojson", Ed318 = "ed-318", Ed269 = "ed-269" });

/// What the configuration says beside a file.
pub(super) struct Reading<'a> {
    /// What an area without a name is called.
    pub(super) stem: String,
    /// The heights of polygons without any.
    pub(super) band: Band,
    /// Above mean sea level, metres.
    pub(super) ground_m: Option<f64>,
    pub(super) language: &'a str,
    pub(super) zone: Option<TimeZone>,
}

impl<'a> Reading<'a> {
    pub(super) fn new(stem: String, settings: &'a AlertArea) -> Self {
        let zone = settings.time_zone.as_deref().and_then(|name| TimeZone::get(name).ok());
        let band = Band::amsl(settings.floor_m, settings.ceiling_m);
        Self { stem, band, ground_m: settings.ground_m, language: &settings.language, zone }
    }

    /// What a zone is called, which without a name is its identifier or else the file's, and its identifier.
    pub(super) fn names(&self, zone: &Member<'_>) -> Result<(String, Option<String>), String> {
        let identifier = self.text(zone, "identifier")?;
        let name = self.text(zone, "name")?.or_else(|| identifier.clone());
        Ok((name.unwrap_or_else(|| self.stem.clone()), identifier))
    }

    /// The text of the member of that name.
    pub(super) fn text(&self, zone: &Member<'_>, name: &str) -> Result<Option<String>, String> {
        zone.get(name).map_or(Ok(None), |text| self.in_language(&text))
    }

    /// A text, or that of several which is in the wanted language, or else in a dialect of it, or else the first.
    fn in_language(&self, member: &Member<'_>) -> Result<Option<String>, String> {
        if !member.value().is_array() && !member.is_object() {
            return Ok(Some(member.text()?.to_owned()));
        }
        let mut texts = Vec::new();
        for entry in member.entries() {
            let language = entry.get("lang").map(|tag| tag.text()).transpose()?.unwrap_or_default();
            match (entry.get("text"), entry.is_object()) {
                (Some(text), _) => texts.push((language, text.text()?)),
                // A language without a text.
                (None, true) => {}
                (None, false) => texts.push((language, entry.text()?)),
            }
        }
        let main = |tag: &str| tag.split('-').next().unwrap_or_default().to_ascii_lowercase();
        let exact = texts.iter().find(|(tag, _)| tag.eq_ignore_ascii_case(self.language));
        let near = || texts.iter().find(|(tag, _)| main(tag) == main(self.language));
        let found = exact.or_else(near).or(texts.first());
        Ok(found.map(|(_, text)| (*text).to_owned()))
    }
}
