//! The report of `locate`, and the keys of a located radar.

use std::fmt::Write as _;
use std::io::{self, Write};

use asterix::DataSource;

use locate::{Estimate, LocatedRadar, NotLocated};

/// Writes the result for one radar. Heights are above mean sea level, which is `undulation_m` above the ellipsoid.
pub(super) fn write(
    out: &mut impl Write,
    source: DataSource,
    result: &Result<LocatedRadar, NotLocated>,
    undulation_m: f64,
) -> io::Result<()> {
    let name = format!("radar {}/{}", source.sac, source.sic);
    let located = match result {
        Ok(located) => located,
        Err(reason) => return writeln!(out, "{name}: not located: {reason}"),
    };
    let of = located.evidence;
    writeln!(
        out,
        "{name}: located from {:.0} s with {} and {}",
        of.common_s,
        counted(of.transponders, "transponder"),
        counted(of.tracks, "radar track"),
    )?;
    let mut line =
        |name: &str, value: String, sigma: String| writeln!(out, "  {name:<18} {value:>14}  ± {sigma}");
    let (north_m, east_m) = (located.covariance_m2[(1, 1)].sqrt(), located.covariance_m2[(0, 0)].sqrt());
    line("latitude", format!("{:.6}°", located.antenna.latitude_deg()), format!("{north_m:.1} m"))?;
    line("longitude", format!("{:.6}°", located.antenna.longitude_deg()), format!("{east_m:.1} m"))?;
    let height = located.height_m;
    line("height", format!("{:.1} m", height.value - undulation_m), format!("{:.1} m", height.sigma))?;
    let mut value = |name: &str, of: Option<Estimate>, digits: usize, unit: &str| match of {
        Some(of) => {
            line(name, format!("{:.digits$}{unit}", of.value), format!("{:.digits$}{unit}", of.sigma))
        }
        None => Ok(()),
    };
    value("bearing", Some(located.bearing_deg), 2, "°")?;
    value("tilt about east", located.tilt_east_deg, 2, "°")?;
    value("tilt about north", located.tilt_north_deg, 2, "°")?;
    value("range offset", Some(located.range_offset_m), 1, " m")?;
    let scale = located.range_scale;
    let per_mille = Estimate { value: scale.value * 1e3, sigma: scale.sigma * 1e3, ..scale };
    value("range scale", Some(per_mille), 2, " ‰")?;
    value("height offset", located.height_offset_m, 1, " m")?;
    value("clock", Some(located.clock_s), 2, " s")?;
    for missing in &located.unobservable {
        writeln!(out, "  {missing}")?;
    }
    Ok(())
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Keys of a located radar in a configuration, with their deviations as comments.
pub(super) fn keys(located: &LocatedRadar, undulation_m: f64) -> String {
    let mut text = String::new();
    let mut key = |name: &str, value: String, comment: String| {
        _ = writeln!(text, "{:<34} # {comment}", format!("{name} = {value}"));
    };
    let (north_m, east_m) = (located.covariance_m2[(1, 1)].sqrt(), located.covariance_m2[(0, 0)].sqrt());
    key("latitude_deg", format!("{:.7}", located.antenna.latitude_deg()), format!("± {north_m:.1} m"));
    key("longitude_deg", format!("{:.7}", located.antenna.longitude_deg()), format!("± {east_m:.1} m"));
    let height = located.height_m;
    let assumed = if height.is_observable() { "" } else { ", mostly assumed" };
    key(
        "height_amsl_m",
        format!("{:.1}", height.value - undulation_m),
        format!("± {:.1} m{assumed}", height.sigma),
    );
    let bearing = located.bearing_deg;
    key("bearing_correction_deg", format!("{:.3}", -bearing.value), format!("± {:.2}", bearing.sigma));
    let (offset, clock) = (located.range_offset_m, located.clock_s);
    _ = writeln!(
        text,
        "# Slant ranges too long by {:.1} ± {:.1} m, time stamps too late by {:.2} ± {:.2} s; there are no keys for them:\n\
         # the service estimates them while it runs.",
        offset.value, offset.sigma, clock.value, clock.sigma
    );
    let height = located.height_sigma_m.map_or(String::new(), |sigma| format!(", height_m = {sigma:.1}"));
    _ = writeln!(
        text,
        "accuracy = {{ range_m = {:.1}, azimuth_deg = {:.2}{height} }}  # standard deviations of the plots",
        located.range_sigma_m.max(0.1),
        located.azimuth_sigma_deg.max(0.01),
    );
    text
}
