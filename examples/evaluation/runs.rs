//! Whole runs of the program, each as a process of its own, and the processor time that they take.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use utm_fusion::config::{Action, Profile};
use utm_fusion::formats::PcapWriter;
use utm_fusion::simulate::Simulation;

use crate::flights::Failure;
use crate::speed::PROFILES;

/// Rounds in which the profiles take turns; the median counts.
const ROUNDS: usize = 5;
/// In each round a profile runs until it has taken that much processor time, seconds: the system counts in hundredths.
const LEAST_S: f64 = 0.5;
/// Ticks of the system's processor times per second (`USER_HZ`).
const TICKS_HZ: f64 = 100.0;

/// Whether a run writes its pictures, one JSON object a track.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Pictures {
    Written,
    /// They are made and counted.
    NotWritten,
}

/// What is run.
#[derive(Clone, Copy)]
pub struct Run {
    pub profile: Profile,
    /// What is done about transponders that lie.
    pub action: Action,
    pub pictures: Pictures,
}

impl Run {
    /// Of each of the [`PROFILES`], as it is usually configured.
    pub fn of_profiles(pictures: Pictures) -> [Self; 2] {
        PROFILES.map(|profile| Self { profile, action: Action::Flag, pictures })
    }

    /// Of the `operational` profile with integrity and without, no pictures written.
    pub fn of_integrity() -> [Self; 2] {
        let (profile, pictures) = (Profile::Operational, Pictures::NotWritten);
        [Action::Flag, Action::Off].map(|action| Self { profile, action, pictures })
    }
}

/// A flight as files, which end with it.
pub struct Files(PathBuf);

impl Files {
    pub fn of(simulation: &Simulation) -> Result<Self, Failure> {
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

    /// Processor time of a run, all its threads, from its start to its end, of each kind, seconds.
    pub fn processor_s<const N: usize>(&self, runs: [Run; N]) -> Result<[f64; N], Failure> {
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

    fn run(&self, run: Run) -> Result<(), Failure> {
        let Run { profile, action, pictures } = run;
        let mut program = Command::new(std::env::current_exe()?);
        program.arg("replay").arg(self.0.join("capture.pcap"));
        program.arg("--config").arg(self.0.join("site.toml")).args(["--profile", profile.name()]);
        program.env("UTM_FUSION__INTEGRITY__ACTION", action.name());
        if pictures == Pictures::Written {
            program.arg("-o").arg(self.0.join("pictures.ndjson"));
        }
        let status = program.stdout(Stdio::null()).status()?;
        if status.success() { Ok(()) } else { Err(format!("{program:?}: {status}").into()) }
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        // They are in the system's folder for what may be lost.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Processor time of the processes that this one has started and that have ended, seconds.
fn children_s() -> Result<f64, Failure> {
    let text = String::from_utf8(fs::read("/proc/self/stat")?)?;
    // Behind the name, which is in brackets and may hold anything: cutime and cstime are the 14th and 15th.
    let fields = text.rsplit_once(')').map_or("", |(_, fields)| fields);
    let ticks: Vec<f64> =
        fields.split_whitespace().skip(13).take(2).map(str::parse).collect::<Result<_, _>>()?;
    Ok(ticks.iter().sum::<f64>() / TICKS_HZ)
}
