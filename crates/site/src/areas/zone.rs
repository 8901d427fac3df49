//! A zone, independent of the format it was read from.

use jiff::tz::TimeZone;

use super::band::{Band, BandAmsl};
use super::member::Member;
use super::schedule::Schedule;
use super::shape::Shape;
use crate::config::AlertArea;

/// A zone of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// Name for users.
    pub name: String,
    /// Identifier assigned by the authority.
    pub identifier: Option<String>,
    /// Restriction of the zone; `None`: a plain polygon without restrictions.
    pub kind: Option<ZoneKind>,
    /// Conditions under which restrictions apply, in the authority's words.
    pub conditions: Option<String>,
    /// Times at which the zone applies.
    pub schedule: Schedule,
    /// Format of the file.
    pub format: Format,
    /// The parts of the zone: it is the union of these.
    pub(super) volumes: Vec<Volume>,
}

/// A part of a zone.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Volume {
    pub(super) shape: Shape,
    pub(super) band: Band,
}

impl Zone {
    /// The name, followed by the identifier if that differs.
    pub fn label(&self) -> String {
        match &self.identifier {
            Some(identifier) if *identifier != self.name => format!("{} ({identifier})", self.name),
            _ => self.name.clone(),
        }
    }

    /// The heights from the lowest part to the highest. `undulation_m`: height of the geoid above the ellipsoid.
    pub fn band_above_sea(&self, undulation_m: f64) -> BandAmsl {
        let bands = || self.volumes.iter().map(|volume| volume.band.above_sea(undulation_m));
        let floors: Option<Vec<f64>> = bands().map(|band| band.floor_m).collect();
        let ceilings: Option<Vec<f64>> = bands().map(|band| band.ceiling_m).collect();
        BandAmsl {
            floor_m: floors.and_then(|floors| floors.into_iter().min_by(f64::total_cmp)),
            ceiling_m: ceilings.and_then(|ceilings| ceilings.into_iter().max_by(f64::total_cmp)),
        }
    }

    /// Whether the zone is limited in height or time.
    pub(super) fn is_limited(&self) -> bool {
        !self.schedule.is_always() || self.volumes.iter().any(|volume| volume.band.is_limited())
    }
}

/// The restriction of a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneKind {
    /// No flights.
    Prohibited,
    /// Flights with an authorisation.
    Authorisation,
    /// Flights that meet the conditions.
    Conditional,
    /// Flights that use the U-space services.
    USpace,
    /// All flights.
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
    /// The restriction as authorities write it.
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

/// File formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// GeoJSON polygons (RFC 7946).
    GeoJson,
    /// UAS zones of EUROCAE ED-318, an extension of GeoJSON.
    Ed318,
    /// UAS zones of EUROCAE ED-269.
    Ed269,
}

fusion::interface_names!(Format { GeoJson = "geojson", Ed318 = "ed-318", Ed269 = "ed-269" });

/// Settings from the configuration that apply to a file.
pub(super) struct Reading<'a> {
    /// Name of a zone without a name.
    pub(super) stem: String,
    /// Heights of polygons without heights.
    pub(super) band: Band,
    /// Height of the ground above mean sea level, in metres.
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

    /// Name and identifier of a zone. A zone without a name is named by its identifier, or else by the file.
    pub(super) fn names(&self, zone: &Member<'_>) -> Result<(String, Option<String>), String> {
        let identifier = self.text(zone, "identifier")?;
        let name = self.text(zone, "name")?.or_else(|| identifier.clone());
        Ok((name.unwrap_or_else(|| self.stem.clone()), identifier))
    }

    /// The text of the member with that name.
    pub(super) fn text(&self, zone: &Member<'_>, name: &str) -> Result<Option<String>, String> {
        zone.get(name).map_or(Ok(None), |text| self.in_language(&text))
    }

    /// A text in the preferred language, or else in another dialect of it, or else the first text.
    fn in_language(&self, member: &Member<'_>) -> Result<Option<String>, String> {
        if !member.value().is_array() && !member.is_object() {
            return Ok(Some(member.text()?.to_owned()));
        }
        let mut texts = Vec::new();
        for entry in member.entries() {
            let language = entry.get("lang").map(|tag| tag.text()).transpose()?.unwrap_or_default();
            match (entry.get("text"), entry.is_object()) {
                (Some(text), _) => texts.push((language, text.text()?)),
                // An entry that names a language and has no text is ignored.
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
