//! `locate`: where the radars of a recording stand and how they are turned, from drones with transponders.

mod plot;
mod text;

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use asterix::DataSource;
use tracing::{error, info};

use super::info::site::{self as site_file, RadarPlace};
use super::{CommandResult, Outcome};
use fusion::frames::Geodetic;
use input::capture::Capture;
use input::survey::Survey;
use locate::AlignmentData;
use locate::{FirstGuess, LocatedRadar, NotLocated, locate};
use site::config::{Config, SensorKind};

/// Finds position, bearing and clock of each radar from drones with transponders, and writes a site file
///
/// The recording holds radar tracks (CAT048) and reports of transponders (CAT129) of the same drones. No first guess is needed.
/// A position in --config, or one that the radar states (I034/120), is tried first. Each value has a standard deviation; a value
/// that the flights do not show is named with what would show it. A radar whose position remains in doubt is not located: the
/// exit code is then 1.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Capture files of one site
    #[arg(required = true, value_name = "CAPTURE")]
    pub inputs: Vec<PathBuf>,
    /// Site configuration with rough positions. The file of --output is then this configuration with the located radars
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Writes the site configuration to this file, which must not exist
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Writes a map of drones and radars, and the residuals before and after, as SVG
    #[arg(long, value_name = "FILE.svg")]
    pub plot: Option<PathBuf>,
}

/// A radar with less than one part in this of the busiest radar's plots is a stray, as in `info`.
const STRAY: usize = 20;

/// A radar with its result.
type Found = (DataSource, Result<LocatedRadar, NotLocated>);

/// Runs the command; the report is written to `out`.
///
/// # Errors
/// An input cannot be opened or read, the configuration is invalid, or a file cannot be written.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    args.output.as_deref().map_or(Ok(()), |file| site_file::check(file, "--output"))?;
    let config = args.config.as_deref().map(Config::load).transpose()?;
    let undulation_m = config.as_ref().and_then(|config| config.site.geoid_undulation_m);
    let mut data = AlignmentData::default().with_undulation(undulation_m);
    let mut survey = Survey::default();
    let captures = args.inputs.iter().map(|path| Capture::open(path)).collect::<Result<Vec<_>, _>>()?;
    let mut outcome = Outcome::Done;
    for next in captures.into_iter().flatten() {
        match next {
            Ok(datagram) => {
                survey.datagram(&datagram);
                data.datagram(&datagram);
            }
            Err(damage) => {
                error!("{damage}");
                outcome = Outcome::InputUnreadable;
            }
        }
    }
    if data.radars.is_empty() {
        return Err("the input has no radar (CAT048)".into());
    }
    let busiest = data.radars.values().map(|radar| radar.plots.len()).max().unwrap_or(0);
    let found: Vec<Found> = (data.radars.iter())
        .filter(|(_, radar)| radar.plots.len().saturating_mul(STRAY) > busiest)
        .map(|(&source, radar)| {
            let configured = config.as_ref().and_then(|config| guess(config, source, data.undulation_m));
            let stated = radar.stated.map(|antenna| FirstGuess { antenna, bearing: 0.0 });
            (source, locate(&data.plots_of(radar), &data.reports, configured.or(stated)))
        })
        .collect();
    let undulation_m = data.undulation_m.unwrap_or(0.0);
    for (source, result) in &found {
        text::write(out, *source, result, undulation_m)?;
    }
    let is_located = |(_, result): &Found| result.is_ok();
    if !found.iter().all(is_located) && outcome == Outcome::Done {
        outcome = Outcome::Incomplete;
    }
    if let Some(file) = &args.plot {
        write_file(file, &plot::svg(&found, &data))?;
    }
    if let Some(file) = &args.output {
        if !found.iter().any(is_located) {
            info!("{}: not written: no radar is located", file.display());
            return Ok(outcome);
        }
        match config {
            Some(config) => write_file(file, &with_places(config, &found, undulation_m).to_string())?,
            None => {
                let inputs: Vec<String> =
                    args.inputs.iter().map(|input| input.display().to_string()).collect();
                let places = places(&found, undulation_m);
                site_file::write(file, "--output", &inputs, survey.report().sensors, &places)?;
            }
        }
        info!("{0}: written; `utm-fusion check {0}` shows all keys", file.display());
    }
    Ok(outcome)
}

fn write_file(file: &Path, text: &str) -> Result<(), Box<dyn Error + Send + Sync>> {
    fs::write(file, text).map_err(|error| format!("{}: cannot be written: {error}", file.display()).into())
}

/// Position and bearing that a configuration states for a radar.
fn guess(config: &Config, source: DataSource, undulation_m: Option<f64>) -> Option<FirstGuess> {
    let sensor = config.sensors.iter().find(|sensor| (sensor.sac, sensor.sic) == (source.sac, source.sic))?;
    let SensorKind::Radar(radar) = &sensor.kind else { return None };
    let height_m = radar.height_amsl_m + undulation_m.unwrap_or(0.0);
    Some(FirstGuess {
        antenna: Geodetic::from_degrees(radar.latitude_deg, radar.longitude_deg, height_m),
        bearing: -radar.bearing_correction_deg.to_radians(),
    })
}

/// Rounds a position to a centimetre and less, as the file shows it.
fn rounded(value: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    (value * scale).round() / scale
}

/// The configuration with the located radars.
fn with_places(mut config: Config, found: &[Found], undulation_m: f64) -> Config {
    for (source, result) in found {
        let Ok(located) = result else { continue };
        let sensor =
            config.sensors.iter_mut().find(|sensor| (sensor.sac, sensor.sic) == (source.sac, source.sic));
        if let Some(SensorKind::Radar(radar)) = sensor.map(|sensor| &mut sensor.kind) {
            radar.latitude_deg = rounded(located.antenna.latitude_deg(), 7);
            radar.longitude_deg = rounded(located.antenna.longitude_deg(), 7);
            radar.height_amsl_m = rounded(located.antenna.height_m - undulation_m, 1);
            radar.bearing_correction_deg = rounded(-located.bearing_deg.value, 3);
        }
    }
    config
}

/// Keys of each located radar, with deviations.
fn places(found: &[Found], undulation_m: f64) -> BTreeMap<(u8, u8), RadarPlace> {
    let place = |(source, result): &Found| {
        let located = result.as_ref().ok()?;
        Some(((source.sac, source.sic), RadarPlace { keys: text::keys(located, undulation_m) }))
    };
    found.iter().filter_map(place).collect()
}
