//! `record`: records received data without an engine.

use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use jiff::SignedDuration;
use tracing::{info, warn};

use super::moment::duration;
use super::{CommandResult, Outcome, check_mqtt, load_live, mqtt_inputs};
use crate::app::{Stop, runtime};
use fusion::time::Time;
use service::live::{Listening, WallClock, listen, now};
use service::net::listen::Arrival;
use service::record::RecordingItem;
use service::record::{RecordedContents, Recorder, RecorderCounts, RecorderQueue, record_into};
use site::config::{Config, ConfigErrors};

/// Records the data received on the inputs of a configuration, or on some addresses, into rotating pcap files, until Ctrl-C.
///
/// `replay` reads the files, with the site.toml that is written beside them. A recording of addresses has none: `info` and
/// `locate` make one from the recording.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Site configuration, which defines the inputs. Its recording and output settings are ignored, except rotate_mib and keep.
    #[arg(long, value_name = "FILE", required_unless_present = "listen", conflicts_with = "listen")]
    pub config: Option<PathBuf>,
    /// Multicast group, or address of this machine (0.0.0.0 for all), and port, such as 239.192.48.1:8048. Repeatable. After an `@`:
    /// this machine's own address on the network of the group.
    #[arg(long, value_name = "ADDRESS:PORT[@INTERFACE]", value_parser = listen_address)]
    pub listen: Vec<ListenAddress>,
    /// Directory of the files; created if missing.
    #[arg(long, value_name = "DIR")]
    pub dir: PathBuf,
    /// Records the inputs of a cluster's nodes from the log instead of listening. `replay --state` reproduces what the nodes
    /// published.
    #[cfg(feature = "cluster")]
    #[arg(long, requires = "config")]
    pub cluster: bool,
    /// Duration, such as 90s, 10m or 8h.
    #[arg(long, value_name = "D", value_parser = duration)]
    pub duration: Option<SignedDuration>,
}

/// An address to record from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListenAddress {
    /// Group or address of this machine, and port.
    pub address: SocketAddrV4,
    /// This machine's own address on the network of the group.
    pub interface: Option<Ipv4Addr>,
}

fn listen_address(text: &str) -> Result<ListenAddress, String> {
    let (address, interface) =
        text.split_once('@').map_or((text, None), |(address, own)| (address, Some(own)));
    let address: SocketAddrV4 = address
        .parse()
        .map_err(|_| format!("{address:?} is no address with a port, such as 239.192.48.1:8048"))?;
    let interface =
        interface.map(|own| own.parse().map_err(|_| format!("{own:?} is no address of this machine")));
    let interface = interface.transpose()?;
    match (address.ip().is_multicast(), interface) {
        (false, Some(_)) => Err("only a multicast group has an interface".to_owned()),
        (_, interface) => Ok(ListenAddress { address, interface }),
    }
}

/// A configuration without a site, with one sensor for each address.
fn config_of(listen: &[ListenAddress]) -> Result<Config, ConfigErrors> {
    let sensor = |(index, listen): (usize, &ListenAddress)| {
        let ListenAddress { address, interface } = listen;
        let key = if address.ip().is_multicast() { "group" } else { "address" };
        let interface = interface.map_or_else(String::new, |own| format!(", interface = \"{own}\""));
        format!(
            "[[sensors]]\nid = \"{index}\"\nkind = \"transponder\"\nsac = 0\nsic = {index}\n\
             inputs = [{{ {key} = \"{}\", port = {}{interface} }}]\n",
            address.ip(),
            address.port(),
        )
    };
    let sensors: String = listen.iter().enumerate().map(sensor).collect();
    // The place and the codes are used by nothing: datagrams are recorded as they come.
    let site = "[site]\nname = \"recorded\"\nsac = 255\nsic = 255\nlatitude_deg = 0\nlongitude_deg = 0\nheight_amsl_m = 0\n";
    let text = format!("{site}{sensors}");
    Config::parse(&text, "--listen", std::iter::empty())
}

/// Interval of the log lines with counters.
const STATISTICS: SignedDuration = SignedDuration::from_secs(10);
/// Interval at which a stop request is checked.
const POLL_INTERVAL: Duration = Duration::from_millis(200);

/// Maximum time for stopped inputs to pass on received data.
const DRAINED: Duration = Duration::from_secs(2);

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let config = match &args.config {
        Some(file) => load_live(file)?,
        None => config_of(&args.listen)?,
    };
    // The recorder would retry, as it does for the service. A recording command has to fail instead.
    std::fs::create_dir_all(&args.dir)
        .map_err(|error| format!("{}: cannot be made: {error}", args.dir.display()))?;
    #[cfg(feature = "cluster")]
    if args.cluster {
        return super::cluster::record(&config, &args.dir, args.duration);
    }
    if let Some(file) = &args.config {
        check_mqtt(file, mqtt_inputs(&config))?;
    }
    let mut record = config.output.record.clone().unwrap_or_else(|| record_into(&args.dir));
    record.dir.clone_from(&args.dir);
    let contents = if args.config.is_some() { RecordedContents::Input } else { RecordedContents::Datagrams };
    let (queue, recorder) = Recorder::start(&config, &record, Vec::new(), contents)?;

    let (runtime, stop) = (runtime(1)?, Stop::listen()?);
    let mut listening = listen(&config, &WallClock::default(), runtime.handle());
    if listening.http_input.take().is_some() {
        warn!("what gateways post over HTTP is not recorded: only a running service is posted to");
    }
    info!(directory = %args.dir.display(), "recording; Ctrl-C ends it");
    hand_on(&listening, queue, &stop, args.duration);

    // The queue is closed, so the recorder writes the rest and ends.
    let recorder = recorder.join();
    let unrecorded = recorder.unwritten + recorder.lost;
    info!(recorded = recorder.written, lost = unrecorded, "stopped");
    Ok(if unrecorded > 0 { Outcome::Incomplete } else { Outcome::Done })
}

fn hand_on(listening: &Listening, mut queue: RecorderQueue, stop: &Stop, duration: Option<SignedDuration>) {
    let began = now();
    let mut told = began;
    let is_over = |at: Time| duration.is_some_and(|duration| at - began >= duration);
    while !stop.comes_within(Duration::ZERO) && !is_over(now()) {
        match listening.arrivals.recv_timeout(POLL_INTERVAL) {
            Ok(arrival) => queue.offer(recorded(arrival)),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        let at = now();
        if at - told >= STATISTICS {
            told = at;
            log_counts(listening, queue.counts());
        }
    }
    // The readers pass on the data received so far; then the channel closes.
    listening.readers.stop();
    while let Ok(arrival) = listening.arrivals.recv_timeout(DRAINED) {
        queue.offer(recorded(arrival));
    }
}

fn recorded(arrival: Arrival) -> RecordingItem {
    let Arrival { received, line, from, payload } = arrival;
    RecordingItem::Input { received, line, from, payload }
}

/// Logs the counters of each input and of the recorder.
fn log_counts(listening: &Listening, counts: RecorderCounts) {
    for (line, counters) in &listening.lines {
        let (open, received) = (&counters.joined, &counters.received);
        let (open, received) = (open.load(Ordering::Relaxed), received.load(Ordering::Relaxed));
        info!(input = line.name(), open, received, "input");
    }
    info!(recorded = counts.written, lost = counts.unwritten + counts.lost, "recorder");
}
