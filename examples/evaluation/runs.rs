//! Runs of the program in separate processes, and their processor time.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use utm_fusion::config::{Action, Profile};
use utm_fusion::formats::PcapWriter;
use utm_fusion::simulate::Simulation;

use crate::flights::EvaluationFailure;
use crate::speed::PROFILES;

/// Number of rounds, in which the profiles take turns; the median counts.
const ROUNDS: usize = 5;
/// Minimum processor time of a profile in each round, seconds; the system counts in hundredths of a second.
const LEAST_S: f64 = 0.5;
/// Ticks of the system's processor times per second (`USER_HZ`).
const TICKS_HZ: f64 = 100.0;

/// Whether a run writes its pictures, one JSON object per track.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum PictureOutput {
    Written,
    /// Pictures are computed and counted, but not written.
    NotWritten,
}

/// Parameters of a run.
#[derive(Clone, Copy)]
pub struct ProgramRun {
    pub profile: Profile,
    /// Action on false transponder reports.
    pub action: Action,
    pub pictures: PictureOutput,
}

impl ProgramRun {
    /// Runs of each of the [`PROFILES`] with the default integrity.
    pub fn of_profiles(pictures: PictureOutput) -> [Self; 2] {
        PROFILES.map(|profile| Self { profile, action: Action::Flag, pictures })
    }

    /// Runs of the `operational` profile with and without integrity, without writing pictures.
    pub fn of_integrity() -> [Self; 2] {
        let (profile, pictures) = (Profile::Operational, PictureOutput::NotWritten);
        [Action::Flag, Action::Off].map(|action| Self { profile, action, pictures })
    }
}

/// Files of a flight, which are deleted on drop.
pub struct FlightFiles(PathBuf);

impl FlightFiles {
    pub fn of(simulation: &Simulation) -> Result<Self, EvaluationFailure> {
        let files = Self(std::env::temp_dir().join(format!("utm-fusion-evaluation-{}", std::process::id())));
        fs::create_dir_all(&files.0)?;
        #[expect(clippy::disallowed_methods, reason = "the capture that the program reads")]
        let mut capture = PcapWriter::new(BufWriter::new(File::create(files.0.join("capture.pcap"))?))?;
        for datagram in &simulation.datagrams {
            capture.write(datagram.flow, datagram.received, &datagram.payload)?;
        }
        capture.flush()?;
        fs::write(files.0.join("site.toml"), simulation.config.to_string())?;
        Ok(files)
    }

    /// Processor time of a run of each kind, over all its threads, seconds.
    pub fn processor_s<const N: usize>(&self, runs: [ProgramRun; N]) -> Result<[f64; N], EvaluationFailure> {
        let mut rounds = runs.map(|_| Vec::new());
        for _ in 0..ROUNDS {
            for (round, run) in rounds.iter_mut().zip(runs) {
                let begin_s = children_s()?;
                let mut count = 0;
                round.push(loop {
                    self.run(run)?;
                    count += 1;
                    let spent_s = children_s()? - begin_s;
                    if spent_s >= LEAST_S {
                        break spent_s / f64::from(count);
                    }
                });
            }
        }
        Ok(rounds.map(|mut round| {
            round.sort_by(f64::total_cmp);
            round[ROUNDS / 2]
        }))
    }

    fn run(&self, run: ProgramRun) -> Result<(), EvaluationFailure> {
        let ProgramRun { profile, action, pictures } = run;
        let mut program = Command::new(std::env::current_exe()?);
        program.arg("replay").arg(self.0.join("capture.pcap"));
        program.arg("--config").arg(self.0.join("site.toml")).args(["--profile", profile.name()]);
        program.env("UTM_FUSION__INTEGRITY__ACTION", action.name());
        if pictures == PictureOutput::Written {
            program.arg("-o").arg(self.0.join("pictures.ndjson"));
        }
        let status = program.stdout(Stdio::null()).status()?;
        if status.success() { Ok(()) } else { Err(format!("{program:?}: {status}").into()) }
    }
}

impl Drop for FlightFiles {
    fn drop(&mut self) {
        // The files are in the system's temporary directory.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Processor time of terminated child processes, seconds.
fn children_s() -> Result<f64, EvaluationFailure> {
    let text = String::from_utf8(fs::read("/proc/self/stat")?)?;
    // The name is in brackets and may contain anything. After it, cutime and cstime are fields 14 and 15.
    let fields = text.rsplit_once(')').map_or("", |(_, fields)| fields);
    let ticks: Vec<f64> =
        fields.split_whitespace().skip(13).take(2).map(str::parse).collect::<Result<_, _>>()?;
    Ok(ticks.iter().sum::<f64>() / TICKS_HZ)
}
