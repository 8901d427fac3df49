//! What keeps the clock of this machine, asked how good it is.
//!
//! Programs are asked, because no well-kept library reads the kernel's word without `unsafe` code here; and because chrony knows
//! better: the kernel's bound grows by half a millisecond a second between two of a daemon's words.
#![expect(clippy::disallowed_methods, reason = "its clock says how long a program may take")]

use std::io::Read;
use std::process::{Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use std::{io, thread};

use super::ClockState;
use crate::live::ClockSource;

/// Time between two questions.
const ASKS: Duration = Duration::from_secs(5);
/// A program that takes longer than this is ended.
const PATIENCE: Duration = Duration::from_secs(2);
/// And how often it is looked whether it has.
const LOOKS: Duration = Duration::from_millis(10);
/// What was said longer ago is not known any more.
const OLD: Duration = Duration::from_secs(60);
/// The kernel's flag that its clock is not synchronised (`STA_UNSYNC` of adjtimex).
const UNSYNCHRONISED: u32 = 0x40;
/// What chrony calls a clock that follows nothing but itself (`local` of its configuration).
const LOCAL: &str = "7F7F0101";

/// Whom to ask, with what, in this order.
type Asked = (ClockSource, &'static str, &'static [&'static str], fn(&str) -> Option<ClockState>);
const ASKED: [Asked; 3] = [
    (ClockSource::Chrony, "chronyc", &["-n", "-c", "tracking"], tracking),
    (ClockSource::Kernel, "adjtimex", &["--print"], timex),
    (ClockSource::Systemd, "timedatectl", &["show", "--property=NTPSynchronized", "--value"], synchronised),
];

/// Asks again and again, on a thread of its own, until it is dropped.
#[derive(Debug)]
pub struct Keeper {
    said: Arc<Mutex<Option<(ClockState, Instant)>>>,
    #[expect(dead_code, reason = "the thread ends with it")]
    asks: Sender<()>,
}

impl Keeper {
    /// Begins to ask.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start() -> io::Result<Self> {
        let said = Arc::<Mutex<_>>::default();
        let (asks, end) = channel::<()>();
        let into = said.clone();
        thread::Builder::new().name("clock".to_owned()).spawn(move || {
            loop {
                let state = ask();
                *into.lock().unwrap_or_else(PoisonError::into_inner) = Some((state, Instant::now()));
                if end.recv_timeout(ASKS) != Err(RecvTimeoutError::Timeout) {
                    return;
                }
            }
        })?;
        Ok(Self { said, asks })
    }

    /// What was said last; `None`: nobody has been asked yet.
    pub fn state(&self) -> Option<ClockState> {
        let said = *self.said.lock().unwrap_or_else(PoisonError::into_inner);
        said.map(|(state, at)| if at.elapsed() < OLD { state } else { ClockState::default() })
    }
}

/// What the first one says that knows.
fn ask() -> ClockState {
    let answer = |(source, program, arguments, read): &Asked| {
        Some(ClockState { by: Some(*source), ..read(&answer(program, arguments)?)? })
    };
    ASKED.iter().find_map(answer).unwrap_or_default()
}

/// What a program says, where it is there, ends in time and well.
fn answer(program: &str, arguments: &[&str]) -> Option<String> {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().ok()?;
    let began = Instant::now();
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if began.elapsed() < PATIENCE => thread::sleep(LOOKS),
            _ => {
                // Either may fail where it has just ended.
                let _ = (child.kill(), child.wait());
                return None;
            }
        }
    };
    let mut text = String::new();
    child.stdout.take()?.take(4096).read_to_string(&mut text).ok()?;
    status.success().then_some(text)
}

/// `chronyc -c tracking`. How far the clock is off at most, after chrony's manual: what is still to be corrected, half of the
/// way to the best clock and back, and what that one and those between may be off.
fn tracking(text: &str) -> Option<ClockState> {
    let fields: Vec<&str> = text.trim().split(',').collect();
    let seconds = |field: usize| fields.get(field)?.parse::<f64>().ok().filter(|seconds| seconds.is_finite());
    let follows = *fields.first()?;
    let is_synchronised = *fields.get(13)? != "Not synchronised" && follows != LOCAL;
    let bound_s = seconds(4)?.abs() + seconds(10)? / 2.0 + seconds(11)?;
    Some(ClockState {
        is_synchronised: Some(is_synchronised),
        bound_s: is_synchronised.then_some(bound_s),
        by: None,
    })
}

/// `adjtimex --print`: the kernel's status, and its largest error in microseconds.
fn timex(text: &str) -> Option<ClockState> {
    let value = |name: &str| {
        let mut lines = text.lines().filter_map(|line| line.split_once(':'));
        lines.find(|(of, _)| of.trim() == name).map(|(_, value)| value.trim())
    };
    let status: u32 = value("status")?.parse().ok()?;
    let largest_us: u32 = value("maxerror")?.parse().ok()?;
    let is_synchronised = status & UNSYNCHRONISED == 0;
    Some(ClockState {
        is_synchronised: Some(is_synchronised),
        bound_s: is_synchronised.then_some(f64::from(largest_us) * 1e-6),
        by: None,
    })
}

/// `timedatectl`, which says no more than whether.
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
    fn chrony_states_what_is_to_be_corrected_the_way_and_what_others_may_be_off() {
        let good = "C0A80001,192.168.0.1,2,1795573492.6,-0.002,0.0001,0.0002,-12.1,0.0,0.1,0.010,0.003,64.2,Normal\n";
        let found = tracking(good).unwrap();
        assert_eq!(found.is_synchronised, Some(true));
        assert!((found.bound_s.unwrap() - 0.010).abs() < 1e-12, "{found:?}");
        // As chrony 4.3 says it.
        let none = "00000000,,0,0.000000000,0.000000000,0.000000000,0.000000000,0.000,0.000,0.000,1.000000000,1.000000000,0.0,Not synchronised\n";
        assert_eq!(tracking(none), state(false, None));
        let local = "7F7F0101,,10,1795573492.624190692,0.000000000,0.000000000,0.000000000,0.000,0.000,0.000,0.000000000,0.000000000,0.0,Normal\n";
        assert_eq!(tracking(local), state(false, None), "a clock that follows itself is no better for it");
        for other in ["", "506 Cannot talk to daemon\n", "a,b,c", &good.replace("-0.002", "nan")] {
            assert_eq!(tracking(other), None, "{other}");
        }
    }

    #[test]
    fn the_kernel_has_a_flag_and_a_largest_error() {
        let said = |maxerror: u32, status: u32| {
            format!(
                "         mode: 0\n     maxerror: {maxerror}\n     esterror: 7\n       status: {status}\n return value = 5\n"
            )
        };
        assert_eq!(timex(&said(16_000_000, 64)), state(false, None));
        assert_eq!(timex(&said(16_000_000, 0x2041)), state(false, None));
        assert_eq!(timex(&said(31_500, 0x2001)), state(true, Some(0.0315)));
        assert_eq!(timex("usage: adjtimex"), None);
    }

    #[test]
    fn systemd_knows_whether_and_no_more() {
        assert_eq!(synchronised("yes\n"), state(true, None));
        assert_eq!(synchronised("no\n"), state(false, None));
        assert_eq!(synchronised("\n"), None);
    }

    #[test]
    fn a_program_that_is_not_there_fails_or_hangs_says_nothing() {
        assert_eq!(answer("sh", &["-c", "echo yes"]).as_deref(), Some("yes\n"));
        assert_eq!(answer("sh", &["-c", "echo yes; exit 1"]), None);
        assert_eq!(answer("no-such-program-here", &[]), None);
        let began = Instant::now();
        assert_eq!(answer("sleep", &["30"]), None);
        assert!(began.elapsed() < Duration::from_secs(20));
    }
}
