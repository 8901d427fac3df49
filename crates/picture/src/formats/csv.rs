//! Pictures as CSV.

use std::io::{self, Write};

use super::table::{ColumnKind, Commas, TableCell, TableColumn, TableWriter};
use super::tracks::{set_cells, track_columns};
use crate::{Picture, PictureMaker, PictureTrack};
use site::config::{Config, Profile};

/// Columns of every profile, in order.
const BASE: [&str; 10] =
    ["time", "id", "source", "track_number", "radar_track", "transponder", "lat", "lon", "alt_msl", "flags"];

/// Columns of Parquet that the base columns contain under other names.
const IN_BASE: [&str; 6] =
    ["latitude_deg", "longitude_deg", "altitude_msl_m", "interpolated", "extrapolated", "transponder_number"];

/// Writer of one line per track. `reference` has the base columns; `operational` adds those of Parquet with the same names.
pub(super) struct CsvWriter<W: Write> {
    table: Box<Commas<W>>,
    /// Indices of the added columns among those of Parquet.
    added: Vec<usize>,
}

impl<W: Write> CsvWriter<W> {
    /// Writes the names of the columns.
    pub(super) fn new(out: W, config: &Config) -> io::Result<Self> {
        let all = track_columns();
        let is_added = |column: &TableColumn| {
            let name = &*column.name;
            config.fusion.profile == Profile::Operational && !BASE.contains(&name) && !IN_BASE.contains(&name)
        };
        let added: Vec<usize> = (0..all.len()).filter(|&index| is_added(&all[index])).collect();
        let base = BASE.into_iter().map(|name| TableColumn::new(name, ColumnKind::Text));
        let columns: Vec<TableColumn> = base.chain(added.iter().map(|&index| all[index].clone())).collect();
        Ok(Self { table: Box::new(Commas::new(out, &columns)?), added })
    }

    /// Writes a line per track: seconds UTC since the epoch, degrees, metres above mean sea level. Unknown values are empty.
    pub(super) fn picture(&mut self, picture: &Picture, maker: &PictureMaker) -> io::Result<()> {
        picture.tracks.iter().try_for_each(|track| {
            for (column, text) in base(track, maker).into_iter().enumerate() {
                self.table.set(column, TableCell::Text(text.into()));
            }
            let added = self.added.iter().copied();
            set_cells(&mut *self.table, BASE.len(), added, track, maker);
            self.table.end_row()
        })
    }

    /// Writes all buffered data.
    pub(super) fn finish(self) -> io::Result<()> {
        self.table.finish()
    }
}

/// Cells of the base columns.
fn base(track: &PictureTrack, maker: &PictureMaker) -> [String; BASE.len()] {
    let source = &track.point.source;
    let nanos = track.time.nanos();
    let optional = |number: Option<u32>| number.map_or_else(String::new, |number| number.to_string());
    let flags = [
        (track.is_interpolated(), "interpolated"),
        (track.is_extrapolated(), "extrapolated"),
        (track.radar_height_missing(), "radar-height-missing"),
    ];
    let flags: Vec<&str> = flags.into_iter().filter_map(|(set, name)| set.then_some(name)).collect();
    [
        // Whole microseconds are exact, because the centre of a slot of whole milliseconds is one.
        format!("{}.{:06}", nanos.div_euclid(1_000_000_000), nanos.rem_euclid(1_000_000_000) / 1000),
        maker.track_id(track),
        track.source_name().to_owned(),
        track.point.number.to_string(),
        optional(source.radar().map(|part| part.track.number.into())),
        optional(source.transponder().map(|part| part.number)),
        format!("{:.9}", track.position.latitude_deg()),
        format!("{:.9}", track.position.longitude_deg()),
        track.altitude_amsl_m.map_or_else(String::new, |altitude| format!("{altitude:.4}")),
        flags.join("+"),
    ]
}
