//! Delivery of alerts to webhooks and a broker on this machine, through the program's own sockets.

pub(crate) mod broker;
mod mqtt;
pub(crate) mod receiver;
mod run;
mod webhook;

use std::time::{Duration, Instant};

use fusion::time::Time;
use utm_fusion::config::Config;
use utm_fusion::live::{Alert, AlertChange, AlertDetails, AlertKind, Messenger, Severity};
use utm_fusion::notices::{Deliveries, NoticeCounts, NoticeReceivers, Notices};

/// Timeout of all waits in these tests.
const PATIENCE: Duration = Duration::from_secs(60);

const SITE: &str = "[site]\nname = \"north\"\nsac = 25\nsic = 1\n\n[[sensors]]\nid = \"radar\"\nkind = \"radar\"\n\
                    sac = 25\nsic = 200\nlatitude_deg = 52.0\nlongitude_deg = -0.5\nheight_amsl_m = 90.0\n";

/// A site with this `[alerts]` configuration.
fn site(alerts: &str) -> Config {
    let text = format!("{SITE}\n{alerts}");
    Config::parse(&text, "/site.toml", std::iter::empty()).unwrap_or_else(|errors| panic!("{errors}"))
}

/// Receivers of the site's alerts.
struct Desk {
    runtime: tokio::runtime::Runtime,
    notices: Notices,
    deliveries: Option<Deliveries>,
}

impl Desk {
    fn open(config: &Config) -> Self {
        let runtime = utm_fusion::app::runtime(1).unwrap();
        let receivers = NoticeReceivers::open(config).unwrap();
        let (notices, deliveries) = runtime.block_on(async { receivers.start() });
        Self { runtime, notices, deliveries: Some(deliveries) }
    }

    fn note(&mut self, change: AlertChange, alert: &Alert) {
        self.notices.note(change, alert);
    }

    fn counts(&self, receiver: &str) -> NoticeCounts {
        self.notices.counts().find(|(name, _)| *name == receiver).unwrap().1
    }

    fn troubles(&self) -> Vec<String> {
        self.notices.troubles().into_iter().map(|trouble| trouble.text).collect()
    }

    /// Ends like the service.
    fn close(&mut self) {
        let deliveries = self.deliveries.take().unwrap();
        self.runtime.block_on(deliveries.close());
    }
}

fn alert(id: u64) -> Alert {
    Alert {
        id,
        kind: AlertKind::Area,
        severity: Severity::Warning,
        worst: Severity::Warning,
        since: Time::from_nanos(1_763_000_000_000_000_000),
        until: None,
        text: "T-1 is inside Airfield".to_owned(),
        subject: "T-1".to_owned(),
        details: AlertDetails::None,
        acknowledged: None,
        shelved: None,
        is_latched: false,
        revision: 0,
    }
}

fn ended(id: u64) -> Alert {
    Alert { until: Some(Time::from_nanos(1_763_000_009_000_000_000)), ..alert(id) }
}

/// Waits until a condition is met.
fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let until = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < until, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}
