//! Queries the service that disciplines this machine's clock.
//!
//! Programs are run because no well-maintained library reads the kernel's clock state without `unsafe` code here. Chrony also has
//! the better bound: the kernel's grows by 0.5 ms each second between two updates of the daemon.
#![expect(clippy::disallowed_methods, reason = "its clock says how long a program may take")]

use std::io::Read;
use std::process::{Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use std::{io, thread};

use crate::gateway_report::ClockState;
use service::live::ClockSource;

/// Interval of the queries.
const QUERY_INTERVAL: Duration = Duration::from_secs(5);
/// Time after which a program is killed.
const PROGRAM_TIMEOUT: Duration = Duration::from_secs(2);
/// Interval at which a running program is checked.
const CHECK_INTERVAL: Duration = Duration::from_millis(10);
/// Age after which an answer is discarded.
const MAX_AGE: Duration = Duration::from_secs(60);
/// The kernel's flag that its clock is not synchronised (`STA_UNSYNC` of adjtimex).
const STA_UNSYNC: u32 = 0x40;
/// Reference identifier of a clock that follows only itself (`local` in chrony's configuration).
const LOCAL_REFERENCE: &str = "7F7F0101";

/// Programs in the order of the queries, with their arguments and parsers.
type ClockProgram = (ClockSource, &'static str, &'static [&'static str], fn(&str) -> Option<ClockState>);
const CLOCK_PROGRAMS: [ClockProgram; 3] = [
    (ClockSource::Chrony, "chronyc", &["-n", "-c", "tracking"], tracking),
    (ClockSource::Kernel, "adjtimex", &["--print"], timex),
    (ClockSource::Systemd, "timedatectl", &["show", "--property=NTPSynchronized", "--value"], synchronised),
];

/// Queries repeatedly on a thread of its own, until dropped.
#[derive(Debug)]
pub struct ClockQuery {
    last_answer: Arc<Mutex<Option<(ClockState, Instant)>>>,
    #[expect(dead_code, reason = "the thread ends with it")]
    end: Sender<()>,
}

impl ClockQuery {
    /// Starts the queries.
    ///
    /// # Errors
    /// The thread cannot be created.
    pub fn start() -> io::Result<Self> {
        let last_answer = Arc::<Mutex<_>>::default();
        let (end, ended) = channel::<()>();
        let into = last_answer.clone();
        thread::Builder::new().name("clock".to_owned()).spawn(move || {
            loop {
                let state = query();
                *into.lock().unwrap_or_else(PoisonError::into_inner) = Some((state, Instant::now()));
                if ended.recv_timeout(QUERY_INTERVAL) != Err(RecvTimeoutError::Timeout) {
                    return;
                }
            }
        })?;
        Ok(Self { last_answer, end })
    }

    /// The last answer; `None` before the first query has ended.
    pub fn state(&self) -> Option<ClockState> {
        let last_answer = *self.last_answer.lock().unwrap_or_else(PoisonError::into_inner);
        last_answer.map(|(state, at)| if at.elapsed() < MAX_AGE { state } else { ClockState::default() })
    }
}

/// The first usable answer of the programs.
fn query() -> ClockState {
    let output_of = |(source, program, arguments, read): &ClockProgram| {
        Some(ClockState { by: Some(*source), ..read(&output_of(program, arguments)?)? })
    };
    CLOCK_PROGRAMS.iter().find_map(output_of).unwrap_or_default()
}

/// Output of a program; `None` if it is missing, fails, or takes too long.
fn output_of(program: &str, arguments: &[&str]) -> Option<String> {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().ok()?;
    let began = Instant::now();
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if began.elapsed() < PROGRAM_TIMEOUT => thread::sleep(CHECK_INTERVAL),
            _ => {
                // Either may fail if the program has just ended.
                let _ = (child.kill(), child.wait());
                return None;
            }
        }
    };
    let mut text = String::new();
    child.stdout.take()?.take(4096).read_to_string(&mut text).ok()?;
    status.success().then_some(text)
}

/// Parses `chronyc -c tracking`. The error bound follows chrony's manual: the remaining correction, half of the root delay, and
/// the root dispersion.
fn tracking(text: &str) -> Option<ClockState> {
    let fields: Vec<&str> = text.trim().split(',').collect();
    let seconds = |field: usize| fields.get(field)?.parse::<f64>().ok().filter(|seconds| seconds.is_finite());
    let follows = *fields.first()?;
    let is_synchronised = *fields.get(13)? != "Not synchronised" && follows != LOCAL_REFERENCE;
    let bound_s = seconds(4)?.abs() + seconds(10)? / 2.0 + seconds(11)?;
    Some(ClockState {
        is_synchronised: Some(is_synchronised),
        bound_s: is_synchronised.then_some(bound_s),
        by: None,
    })
}

/// Parses `adjtimex --print`: the kernel's status, and its maximum error in microseconds.
fn timex(text: &str) -> Option<ClockState> {
    let value = |name: &str| {
        let mut lines = text.lines().filter_map(|line| line.split_once(':'));
        lines.find(|(of, _)| of.trim() == name).map(|(_, value)| value.trim())
    };
    let status: u32 = value("status")?.parse().ok()?;
    let largest_us: u32 = value("maxerror")?.parse().ok()?;
    let is_synchronised = status & STA_UNSYNC == 0;
    Some(ClockState {
        is_synchronised: Some(is_synchronised),
        bound_s: is_synchronised.then_some(f64::from(largest_us) * 1e-6),
        by: None,
    })
}

/// Parses `timedatectl`, which states synchronisation but no bound.
fn synchronised(text: &str) -> Option<ClockState> {
    let is_synchronised = match text.trim() {
        "yes" => true,
        "no" => false,
        _ => return None,
    };
    Some(ClockState { is_synchronised: Some(is_synchronised), bound_s: None, by: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(is_synchronised: bool, bound_s: Option<f64>) -> Option<ClockState> {
        Some(ClockState { is_synchronised: Some(is_synchronised), bound_s, by: None })
    }

    #[test]
    fn chrony_bound_adds_correction_delay_and_dispersion() {
        let good = "C0A80001,192.168.0.1,2,1795573492.6,-0.002,0.0001,0.0002,-12.1,0.0,0.1,0.010,0.003,64.2,Normal\n";
        let found = tracking(good).unwrap();
        assert_eq!(found.is_synchronised, Some(true));
        assert!((found.bound_s.unwrap() - 0.010).abs() < 1e-12, "{found:?}");
        // Output of chrony 4.3.
        let none = "00000000,,0,0.000000000,0.000000000,0.000000000,0.000000000,0.000,0.000,0.000,1.000000000,1.000000000,0.0,Not synchronised\n";
        assert_eq!(tracking(none), state(false, None));
        let local = "7F7F0101,,10,1795573492.624190692,0.000000000,0.000000000,0.000000000,0.000,0.000,0.000,0.000000000,0.000000000,0.0,Normal\n";
        assert_eq!(tracking(local), state(false, None), "a clock that follows itself is no better for it");
        for other in ["", "506 Cannot talk to daemon\n", "a,b,c", &good.replace("-0.002", "nan")] {
            assert_eq!(tracking(other), None, "{other}");
        }
    }

    #[test]
    fn kernel_state_has_flag_and_maximum_error() {
        let last_answer = |maxerror: u32, status: u32| {
            format!(
                "         mode: 0\n     maxerror: {maxerror}\n     esterror: 7\n       status: {status}\n return value = 5\n"
            )
        };
        assert_eq!(timex(&last_answer(16_000_000, 64)), state(false, None));
        assert_eq!(timex(&last_answer(16_000_000, 0x2041)), state(false, None));
        assert_eq!(timex(&last_answer(31_500, 0x2001)), state(true, Some(0.0315)));
        assert_eq!(timex("usage: adjtimex"), None);
    }

    #[test]
    fn systemd_state_has_no_bound() {
        assert_eq!(synchronised("yes\n"), state(true, None));
        assert_eq!(synchronised("no\n"), state(false, None));
        assert_eq!(synchronised("\n"), None);
    }

    #[test]
    fn missing_failing_or_hanging_program_has_no_answer() {
        assert_eq!(output_of("sh", &["-c", "echo yes"]).as_deref(), Some("yes\n"));
        assert_eq!(output_of("sh", &["-c", "echo yes; exit 1"]), None);
        assert_eq!(output_of("no-such-program-here", &[]), None);
        let began = Instant::now();
        assert_eq!(output_of("sleep", &["30"]), None);
        assert!(began.elapsed() < Duration::from_secs(20));
    }
}
