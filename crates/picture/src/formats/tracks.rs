//! Pictures as a table: one row per track and slot, with the values of NDJSON.

use std::borrow::Cow;

use super::table::{ColumnKind, TableCell, TableColumn, TableWriter};
use crate::{PictureMaker, PictureTrack, serial_text, text};
use fusion::integrity::{PointIntegrity, Reason};
use fusion::point::{Association, AssociationEvidence, RadarPart, TransponderPart};
use fusion::report::Space;
use fusion::{Source, time::Time};
use input::json::rounded;

/// A column of tracks: name with unit, type, and the function that computes a cell.
type TrackColumn = (&'static str, ColumnKind, for<'a> fn(&TrackTableRow<'a>) -> Option<TableCell<'a>>);

/// A track, with the data for its cells.
struct TrackTableRow<'a> {
    track: &'a PictureTrack,
    maker: &'a PictureMaker,
    radar: Option<&'a RadarPart>,
    transponder: Option<&'a TransponderPart>,
    pair: Option<&'a Association>,
    integrity: Option<&'a PointIntegrity>,
}

/// All columns. They are the same for every configuration, so that files can be joined.
const COLUMNS: &[TrackColumn] = &[
    ("time", ColumnKind::Instant, |row| instant(row.track.time)),
    ("id", ColumnKind::Text, |row| owned(row.maker.track_id(row.track))),
    ("source", ColumnKind::Text, |row| name(row.track.source_name())),
    ("track_number", ColumnKind::Count, |row| count(row.track.point.number)),
    ("state", ColumnKind::Text, |row| name(if row.track.is_coasting() { "coasting" } else { "active" })),
    ("latitude_deg", ColumnKind::Quantity, |row| quantity(row.track.position.latitude_deg(), 9)),
    ("longitude_deg", ColumnKind::Quantity, |row| quantity(row.track.position.longitude_deg(), 9)),
    ("height_ellipsoid_m", ColumnKind::Quantity, |row| {
        row.track.altitude_amsl_m.and_then(|_| quantity(row.track.position.height_m, 3))
    }),
    ("altitude_msl_m", ColumnKind::Quantity, |row| {
        row.track.altitude_amsl_m.and_then(|metres| quantity(metres, 3))
    }),
    ("speed_m_s", ColumnKind::Quantity, |row| quantity(row.track.motion?.speed(), 2)),
    ("track_deg", ColumnKind::Quantity, |row| {
        // A direction rounded up to 360 is north.
        Some(TableCell::Quantity(rounded(row.track.motion?.track_deg?, 1) % 360.0))
    }),
    ("vertical_speed_m_s", ColumnKind::Quantity, |row| quantity(row.track.vertical_motion()?.climb(), 2)),
    ("accuracy_h_m", ColumnKind::Quantity, |row| quantity(row.track.motion?.accuracy_h_m, 2)),
    ("accuracy_v_m", ColumnKind::Quantity, |row| quantity(row.track.vertical_motion()?.accuracy_v_m, 2)),
    ("ellipse_major_m", ColumnKind::Quantity, |row| quantity(row.track.motion?.ellipse?.half_axes_m[0], 2)),
    ("ellipse_minor_m", ColumnKind::Quantity, |row| quantity(row.track.motion?.ellipse?.half_axes_m[1], 2)),
    ("ellipse_azimuth_deg", ColumnKind::Quantity, |row| {
        Some(TableCell::Quantity(rounded(row.track.motion?.ellipse?.azimuth_deg, 1) % 180.0))
    }),
    ("interpolated", ColumnKind::Flag, |row| flag(row.track.is_interpolated())),
    ("extrapolated", ColumnKind::Flag, |row| flag(row.track.is_extrapolated())),
    ("uav_probability", ColumnKind::Quantity, |row| quantity(row.radar?.uav_probability?, 4)),
    ("aircraft_type", ColumnKind::Text, |row| name(row.maker.class(row.track).name())),
    ("serial_number", ColumnKind::Text, |row| identity(row, Space::Serial)),
    ("registration_id", ColumnKind::Text, |row| identity(row, Space::Registration)),
    ("utm_id", ColumnKind::Text, |row| identity(row, Space::Flight)),
    ("specific_session_id", ColumnKind::Text, |row| identity(row, Space::Session)),
    ("manufacturer", ColumnKind::Text, |row| said(uas(row)?.items.manufacturer.as_ref()?)),
    ("model", ColumnKind::Text, |row| said(uas(row)?.items.model.as_ref()?)),
    ("registration_country", ColumnKind::Text, |row| said(uas(row)?.items.registration_country.as_ref()?)),
    ("icao24", ColumnKind::Text, |row| identity(row, Space::Address)),
    ("callsign", ColumnKind::Text, |row| said(&addressed(row)?.aircraft.callsign)),
    ("emitter_category", ColumnKind::Count, |row| count(addressed(row)?.aircraft.emitter_category?)),
    ("integrity", ColumnKind::Text, |row| name(row.integrity?.state.name())),
    ("integrity_index", ColumnKind::Quantity, |row| quantity(row.integrity?.index, 2)),
    ("protection_level_m", ColumnKind::Quantity, |row| quantity(row.integrity?.protection_level_m?, 1)),
    ("offset_m", ColumnKind::Quantity, |row| quantity(row.integrity?.offset_m?, 1)),
    ("reasons", ColumnKind::Text, |row| list(row.integrity?.reasons.iter().map(Reason::name))),
    ("linked", ColumnKind::Text, |row| list(row.track.disputed.iter().map(String::as_str))),
    ("uncooperative", ColumnKind::Flag, |row| flag(row.track.is_uncooperative)),
    ("first_seen", ColumnKind::Instant, |row| instant(row.track.point.first_seen)),
    ("last_measurement", ColumnKind::Instant, |row| instant(row.track.motion?.last_measurement?)),
    ("radar", ColumnKind::Text, |row| name(row.maker.sensor(row.radar?.track.sensor))),
    ("radar_track", ColumnKind::Count, |row| count(row.radar?.track.number)),
    ("radar_time", ColumnKind::Instant, |row| instant(row.radar?.time)),
    ("radar_height_measured", ColumnKind::Flag, |row| flag(row.radar?.height_measured)),
    ("transponder", ColumnKind::Text, |row| name(row.maker.sensor(row.transponder?.sensor))),
    ("transponder_number", ColumnKind::Count, |row| count(row.transponder?.number)),
    ("transponder_time", ColumnKind::Instant, |row| instant(row.transponder?.time?)),
    ("distance_m", ColumnKind::Quantity, |row| quantity(row.pair?.distance_m, 3)),
    ("threshold_m", ColumnKind::Quantity, |row| match row.pair?.because {
        AssociationEvidence::Ratio { threshold_m, .. } => quantity(threshold_m, 3),
        _ => None,
    }),
    ("ratio", ColumnKind::Quantity, |row| match row.pair?.because {
        AssociationEvidence::Ratio { ratio, .. } => quantity(ratio.value(), 4),
        _ => None,
    }),
    ("log_likelihood_ratio", ColumnKind::Quantity, |row| match row.pair?.because {
        AssociationEvidence::Likelihood { score } => quantity(score, 2),
        AssociationEvidence::Manual { score } => quantity(score?, 2),
        AssociationEvidence::Ratio { .. } => None,
    }),
    ("manual", ColumnKind::Flag, |row| flag(matches!(row.pair?.because, AssociationEvidence::Manual { .. }))),
];

/// Columns of [`write_track`].
pub fn track_columns() -> Vec<TableColumn> {
    COLUMNS.iter().map(|(name, kind, _)| TableColumn::new(*name, *kind)).collect()
}

/// Adds the row of a track made by `maker`.
///
/// # Errors
/// The table returns an error.
pub fn write_track(
    table: &mut (impl TableWriter + ?Sized),
    track: &PictureTrack,
    maker: &PictureMaker,
) -> std::io::Result<()> {
    set_cells(table, 0, 0..COLUMNS.len(), track, maker);
    table.end_row()
}

/// Sets the cells of some of [`track_columns`], by index, in consecutive columns of the current row from `first` on.
pub(super) fn set_cells(
    table: &mut (impl TableWriter + ?Sized),
    first: usize,
    chosen: impl IntoIterator<Item = usize>,
    track: &PictureTrack,
    maker: &PictureMaker,
) {
    let source = &track.point.source;
    let row = TrackTableRow {
        track,
        maker,
        radar: source.radar(),
        transponder: source.transponder(),
        pair: match source {
            Source::Fused(_, _, pair) => Some(pair),
            _ => None,
        },
        integrity: track.point.integrity.as_ref(),
    };
    for (column, index) in chosen.into_iter().enumerate() {
        let (_, _, cell) = COLUMNS[index];
        if let Some(cell) = cell(&row) {
            table.set(first + column, cell);
        }
    }
}

/// Identity of this kind, if the track has one.
fn identity(row: &TrackTableRow<'_>, space: Space) -> Option<TableCell<'static>> {
    let identity = row.transponder?.identity;
    if identity.space() == space { owned(serial_text(identity)) } else { None }
}

/// Transponder with the identity of a drone.
fn uas<'a>(row: &TrackTableRow<'a>) -> Option<&'a TransponderPart> {
    row.transponder.filter(|part| part.identity.space() != Space::Address)
}

/// Transponder with an ICAO address.
fn addressed<'a>(row: &TrackTableRow<'a>) -> Option<&'a TransponderPart> {
    row.transponder.filter(|part| part.identity.space() == Space::Address)
}

fn instant(time: Time) -> Option<TableCell<'static>> {
    Some(TableCell::Instant(time))
}

fn name(text: &str) -> Option<TableCell<'_>> {
    Some(TableCell::Text(Cow::Borrowed(text)))
}

fn owned(text: String) -> Option<TableCell<'static>> {
    Some(TableCell::Text(Cow::Owned(text)))
}

/// Text from the octets of a transponder's report.
fn said(octets: &[u8]) -> Option<TableCell<'_>> {
    text(octets).map(TableCell::Text)
}

fn count(number: impl Into<i64>) -> Option<TableCell<'static>> {
    Some(TableCell::Count(number.into()))
}

fn flag(flag: bool) -> Option<TableCell<'static>> {
    Some(TableCell::Flag(flag))
}

/// Physical value with as many decimals as in NDJSON.
fn quantity(value: f64, decimals: i32) -> Option<TableCell<'static>> {
    Some(TableCell::Quantity(rounded(value, decimals)))
}

/// Several names in one text, as in CSV; `None` if there are none.
fn list<'a>(names: impl Iterator<Item = &'a str>) -> Option<TableCell<'static>> {
    let names: Vec<_> = names.collect();
    if names.is_empty() { None } else { owned(names.join("+")) }
}
