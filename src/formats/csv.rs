//! Pictures as CSV.

use std::io::{self, Write};

use crate::config::Config;
use crate::picture::{Picture, PictureMaker, PictureTrack};
use fusion::integrity::Reason;

/// The columns of a site: those of integrity are there only where it is judged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Columns {
    with_integrity: bool,
}

impl Columns {
    /// Of a configuration.
    pub(super) fn of(config: &Config) -> Self {
        Self { with_integrity: config.judges_integrity() }
    }

    /// Writes their names.
    pub(super) fn header(self, out: &mut impl Write) -> io::Result<()> {
        write!(out, "time,id,source,track_number,radar_track,transponder,lat,lon,alt_msl,flags")?;
        if self.with_integrity {
            write!(
                out,
                ",integrity,integrity_index,protection_level_m,offset_m,reasons,linked,uncooperative"
            )?;
        }
        writeln!(out)
    }

    /// Writes a line per track: seconds UTC since the epoch, degrees, metres above mean sea level; unknown values are empty.
    pub(super) fn picture(
        self,
        out: &mut impl Write,
        picture: &Picture,
        maker: &PictureMaker,
    ) -> io::Result<()> {
        picture.tracks.iter().try_for_each(|track| {
            line(out, track, maker)?;
            if self.with_integrity {
                integrity(out, track)?;
            }
            writeln!(out)
        })
    }
}

fn line(out: &mut impl Write, track: &PictureTrack, maker: &PictureMaker) -> io::Result<()> {
    let source = &track.point.source;
    let nanos = track.time.nanos();
    // Whole microseconds, exactly: the centre of a slot of whole milliseconds.
    write!(out, "{}.{:06}", nanos.div_euclid(1_000_000_000), nanos.rem_euclid(1_000_000_000) / 1000)?;
    write!(out, ",{},{},{}", maker.track_id(track), track.source_name(), track.point.number)?;
    let optional = |number: Option<u32>| number.map_or(String::new(), |number| number.to_string());
    write!(out, ",{}", optional(source.radar().map(|part| part.track.number.into())))?;
    write!(out, ",{}", optional(source.transponder().map(|part| part.number)))?;
    write!(out, ",{:.9},{:.9},", track.position.latitude_deg(), track.position.longitude_deg())?;
    if let Some(altitude) = track.altitude_amsl_m {
        write!(out, "{altitude:.4}")?;
    }
    let flags = [
        (track.is_interpolated(), "interpolated"),
        (track.is_extrapolated(), "extrapolated"),
        (track.radar_height_missing(), "radar-height-missing"),
    ];
    let flags: Vec<&str> = flags.into_iter().filter_map(|(set, name)| set.then_some(name)).collect();
    write!(out, ",{}", flags.join("+"))
}

/// State, index, protection level, offset, reasons, ids of the tracks that are disputed with it, and whether it is
/// uncooperative.
fn integrity(out: &mut impl Write, track: &PictureTrack) -> io::Result<()> {
    let (linked, uncooperative) = (track.disputed.join("+"), track.is_uncooperative);
    let Some(integrity) = &track.point.integrity else {
        return write!(out, ",,,,,,{linked},{uncooperative}");
    };
    let metres = |metres: Option<f64>| metres.map_or(String::new(), |metres| format!("{metres:.1}"));
    let reasons: Vec<&str> = integrity.reasons.iter().map(Reason::name).collect();
    write!(
        out,
        ",{},{:.2},{},{},{},{linked},{uncooperative}",
        integrity.state.name(),
        integrity.index,
        metres(integrity.protection_level_m),
        metres(integrity.offset_m),
        reasons.join("+"),
    )
}
