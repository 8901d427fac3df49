//! Pictures as CSV.

use std::io::{self, Write};

use crate::picture::{Picture, PictureMaker, PictureTrack};

/// Writes the names of the columns.
pub(super) fn header(out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "time,id,source,track_number,radar_track,transponder,lat,lon,alt_msl,flags")
}

/// Writes a line a track: seconds UTC since the epoch, degrees, metres above mean sea level; what is unknown is empty.
pub(super) fn picture(out: &mut impl Write, picture: &Picture, maker: &PictureMaker) -> io::Result<()> {
    picture.tracks.iter().try_for_each(|track| line(out, track, maker))
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
    writeln!(out, ",{}", flags.join("+"))
}
