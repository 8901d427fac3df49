//! GPX 1.0 and 1.1: tracks of a logger.

use roxmltree::{Document, Node};

use super::cells;
use super::error::InputFileError;
use super::parsed::TruthTracks;
use crate::evaluate::place::GeodeticPlace;
use fusion::time::Time;

/// Reads tracks: `trkpt` with `lat`, `lon`, `time` and optionally `ele` (metres above mean sea level). The id is the
/// track's name, else `stem`. Tracks with the same id are one drone.
pub(super) fn truth(name: &str, stem: &str, text: &str) -> Result<TruthTracks, InputFileError> {
    let document = Document::parse(text).map_err(|error| {
        InputFileError::at(name, error.pos().row.into(), format!("this is no well-formed XML: {error}"))
    })?;
    if !document.root_element().has_tag_name_of("gpx") {
        return Err(InputFileError::whole(name, "is XML, but no GPX; give a truth as CSV or GPX"));
    }
    let mut tracks = TruthTracks::new();
    for track in document.descendants().filter(|node| node.has_tag_name_of("trk")) {
        let id = track.child_text("name").unwrap_or(stem);
        let points = track.descendants().filter(|node| node.has_tag_name_of("trkpt"));
        let samples = points.map(|point| sample(name, &document, point)).collect::<Result<Vec<_>, _>>()?;
        tracks.push((id.to_owned(), samples));
    }
    if tracks.iter().all(|(_, samples)| samples.is_empty()) {
        return Err(InputFileError::whole(
            name,
            "is GPX without a track point (trkpt); routes and waypoints have no times",
        ));
    }
    Ok(tracks)
}

fn sample(
    name: &str,
    document: &Document<'_>,
    point: Node<'_, '_>,
) -> Result<(Time, GeodeticPlace), InputFileError> {
    let error = |what: String| {
        let line = document.text_pos_at(point.range().start).row;
        InputFileError::at(name, line.into(), what)
    };
    let degrees = |attribute: &str, most: f64| {
        let text = point.attribute(attribute).unwrap_or_default();
        cells::number(text, -most, most)
            .ok_or_else(|| error(format!("{attribute}: {text:?} is no number of degrees")))
    };
    let time = point.child_text("time").unwrap_or_default();
    let time = cells::time(time).ok_or_else(|| {
        error(format!(
            "a track point without a time that can be read ({time:?}); export the log with its times"
        ))
    })?;
    let altitude_amsl_m = match point.child_text("ele") {
        Some(text) => Some(
            cells::number(text, -1_000.0, 100_000.0)
                .ok_or_else(|| error(format!("ele: {text:?} is no number of metres")))?,
        ),
        None => None,
    };
    Ok((
        time,
        GeodeticPlace {
            latitude_deg: degrees("lat", 90.0)?,
            longitude_deg: degrees("lon", 180.0)?,
            altitude_amsl_m,
        },
    ))
}

/// Element lookup by local name: the namespace differs between versions and writers.
trait LocalNames<'a> {
    fn has_tag_name_of(&self, name: &str) -> bool;
    /// Text of the child element with this name, trimmed; `None` if it is empty.
    fn child_text(&self, name: &str) -> Option<&'a str>;
}

impl<'a> LocalNames<'a> for Node<'a, '_> {
    fn has_tag_name_of(&self, name: &str) -> bool {
        self.is_element() && self.tag_name().name() == name
    }

    fn child_text(&self, name: &str) -> Option<&'a str> {
        let child = self.children().find(|child| child.has_tag_name_of(name))?;
        child.text().map(str::trim).filter(|text| !text.is_empty())
    }
}
