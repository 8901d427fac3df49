//! `/metrics`: Prometheus text format, one sample per line.
//!
//! Written without a library: the crate `prometheus-client` has no summaries and names counters differently.

mod members;
mod notices;
mod process;
mod sensors;
mod sinks;
mod text;

use std::sync::Arc;

use super::request::{ApiRequest, ApiResult, live};
use super::slot_json::SlotJson;
use super::tls::Tls;
use super::track_slice::SOURCES;
use fusion::SensorIndex;
use fusion::integrity::{Reason, State};
use fusion::numbering::LARGEST_TRANSPONDER_NUMBER;
use fusion::operational::Verdict;
use service::live::{Alert, AlertKind, ConflictReports, ServiceLevel, Severity, Status, TrustAssessments};
use site::config::Config;
use text::Metrics;

pub(super) use process::open_files;

pub const TEXT: &str = "text/plain; version=0.0.4; charset=utf-8";

/// All metrics.
pub fn text(request: &ApiRequest) -> ApiResult {
    let state = &request.state;
    let hub = &state.hub;
    let latest = state.log.latest().1;
    let mut out = Metrics::new("utm_fusion_");
    out.family("info", "The running version");
    out.sample("info", &[("version", env!("CARGO_PKG_VERSION")), ("site", &hub.config.site.name)], 1);
    out.one("start_time_seconds", "When the service started", hub.started.as_seconds());
    out.one("slots_published_total", "Slots published", latest.as_ref().map_or(0, |slot| slot.frame.seq));
    out.one(
        "tracks",
        "Tracks in the latest slot",
        latest.as_ref().map_or(0, |slot| slot.default_tracks().count()),
    );
    let of_source = |source| {
        latest.as_ref().map_or(0, |slot| slot.default_tracks().filter(|slice| slice.source == source).count())
    };
    let help = "Tracks in the latest slot, by what they are made of";
    out.by("tracks_of_source", help, "source", SOURCES.map(|source| (source, of_source(source))));
    out.alerts(&hub.alerts());
    out.notices(&state.options.notices);
    out.sinks(&state.options.sinks);
    out.one("streams", "Open event streams", state.stream_limit.open_streams());
    out.by(
        "streams_dropped_total",
        "WebSockets closed: slow, a message was not taken; silent, no answer to a ping; protocol, something else was sent",
        "reason",
        state.stream_limit.drops().map(|(reason, count)| (reason.name(), count)),
    );
    out.one("http_connections", "Open HTTP connections", state.connection_limit.open());
    out.by(
        "http_connections_refused_total",
        "Connections closed at once: address, one address has too many; full, there are too many in all; tls, no handshake",
        "reason",
        state.connection_limit.refused().map(|(reason, count)| (reason.name(), count)),
    );
    if let Some(expires) = state.access().tls.as_ref().and_then(Tls::expires) {
        let help = "When the TLS certificate expires, seconds since 1970";
        out.one("http_certificate_expires_seconds", help, expires.as_seconds());
    }
    out.by("http_responses_total", "HTTP responses by status", "status", state.answered());
    let help = "Requests refused with 429 because an address or a token asked too often";
    out.one("http_requests_limited_total", help, state.limited());
    let help = "Requests refused with 503 because too many expensive answers were asked for at once";
    out.one("http_expensive_refused_total", help, state.renderer.refused());
    if let Some(history) = &state.options.history {
        out.one("history_failing", "Whether the history cannot be written", u8::from(history.is_failing()));
        out.one("history_lost_total", "Pictures missing in the history", history.lost());
    }
    if let Some(health) = &state.options.state {
        let files = health.all();
        let failing = files.values().filter(|file| file.failing.is_some()).count();
        out.one("state_failing", "Files of the state directory that cannot be written", failing);
        let damaged = files.values().map(|file| file.damaged).sum::<u64>();
        let help = "Damaged files of the state directory that were set aside, the history included";
        out.one("state_damaged_total", help, damaged);
    }
    let held = hub.correlation_requests.in_force();
    let in_force = |verdict| held.iter().filter(|held| held.correlation.verdict == verdict).count();
    let verdicts =
        [Verdict::Correlated, Verdict::Decorrelated].map(|verdict| (verdict.name(), in_force(verdict)));
    out.by("decisions", "Correlations decided by operators that are in force", "verdict", verdicts);
    if hub.config.predicts_conflicts() {
        out.conflicts(&hub.conflict_reports);
    }
    out.integrity(&hub.trust_requests.in_force());
    let uncooperative = |slot: &Arc<SlotJson>| {
        slot.frame.picture.tracks.iter().filter(|track| track.is_uncooperative).count()
    };
    let help = "Tracks in the latest slot that fly without a transponder where one would be heard";
    out.one("uncooperative", help, latest.as_ref().map_or(0, uncooperative));
    let level = match state.condition().level() {
        ServiceLevel::NotReady => 0,
        ServiceLevel::Degraded => 1,
        ServiceLevel::Ok => 2,
    };
    out.one("condition", "0 not ready, 1 degraded, 2 ok", level);
    if let Some(lateness) = hub.lateness() {
        let help = "How much later than configured the picture is, the most in the last 3 s; above 1 it is not ready";
        out.one("picture_late_seconds", help, lateness.late.as_secs_f64());
    }
    if let Some(timings) = hub.timings() {
        let help = "From when a slot was due to its publication, since the start";
        out.histogram("slot_lateness_seconds", help, &timings.lateness);
        let help = "From the time that a slot's positions are of to its publication, since the start";
        out.histogram("slot_latency_seconds", help, &timings.latency);
    }
    if let Some(members) = hub.members() {
        out.members(&members);
    }
    if let Some(recorded) = hub.recorded() {
        out.one("recorder_failing", "Whether the disk fails", u8::from(recorded.failing));
        out.one("recorded_total", "Datagrams recorded", recorded.written);
        out.one("recorder_unwritten_total", "Datagrams not recorded: the disk failed", recorded.unwritten);
        out.one("recorder_lost_total", "Datagrams not recorded: the recorder did not keep up", recorded.lost);
    }
    if let Some(status) = hub.status() {
        out.tally(&status, &hub.config);
        out.all_of_sensors(&status.sensors);
    }
    Ok(live(TEXT, out.into_text() + &process::text()))
}

impl Metrics {
    /// Conflicts of the latest second.
    fn conflicts(&mut self, outlooks: &ConflictReports) {
        let latest = outlooks.latest();
        let of_level = |level: conflict::Level| {
            let all = latest.iter().flat_map(|outlook| &outlook.conflicts);
            (level.name(), all.filter(|conflict| conflict.level() == Some(level)).count())
        };
        let help = "Pairs of aircraft and volumes of the latest second that hold a level";
        self.by("conflicts", help, "level", conflict::Level::ALL.map(of_level));
        let help = "Aircraft that took part in the latest search for conflicts";
        self.one("conflict_aircraft", help, latest.as_ref().map_or(0, |outlook| outlook.aircraft));
        let help = "Pairs of aircraft that were near enough to be looked at in the latest second";
        self.one("conflict_pairs_tested", help, latest.as_ref().map_or(0, |outlook| outlook.tested));
        self.one("conflict_seconds", "Time that the latest search took", outlooks.spent().as_secs_f64());
        let help = "Seconds whose conflicts came too late to be shown";
        self.one("conflicts_dropped_total", help, outlooks.dropped());
    }

    /// Active alerts.
    fn alerts(&mut self, alerts: &[Arc<Alert>]) {
        self.family("alerts", "Alerts that last, by what they are about");
        let severities = [Severity::Warning, Severity::Critical];
        let last = || alerts.iter().filter(|alert| alert.until.is_none());
        for (kind, severity) in
            AlertKind::ALL.into_iter().flat_map(|kind| severities.map(|severity| (kind, severity)))
        {
            let count = last().filter(|alert| alert.kind == kind && alert.severity == severity).count();
            self.sample("alerts", &[("kind", kind.name()), ("severity", severity.name())], count);
        }
    }

    /// Integrity of transponders.
    fn integrity(&mut self, known: &TrustAssessments) {
        let in_state = |state| known.assessments.iter().filter(|one| one.integrity.state == state).count();
        let states = State::ALL.map(|state| (state.name(), in_state(state)));
        self.by(
            "integrity",
            "Transponders heard in the last hour, by whether they can be trusted",
            "state",
            states,
        );
        let flags = Reason::ALL.map(|reason| (reason.name(), known.flags.get(&reason).copied().unwrap_or(0)));
        let help = "Times that something began to speak against a transponder";
        self.by("integrity_flags_total", help, "reason", flags);
    }

    fn tally(&mut self, status: &Status, config: &Config) {
        let tally = &status.tally;
        let name =
            |index: SensorIndex| config.sensors.get(usize::from(index.0)).map_or("", |s| s.id.as_str());
        self.one("datagrams_received_total", "Datagrams received", tally.received);
        self.one("received_bytes_total", "Octets received", tally.octets);
        self.one("datagrams_duplicate_total", "Datagrams that came twice", tally.duplicates);
        self.one("several_records_total", "CAT129 blocks with several records", tally.several_records);
        self.one("restarts_total", "Fresh starts after a silence", tally.restarts);
        self.one("clock_behind_total", "Steps back of the clock of reception", tally.clock_behind);
        self.one("failed_sends_total", "Datagrams that could not be sent", status.failed_sends);
        self.family("faults_total", "Unreadable blocks and records");
        for ((category, reason), count) in &tally.faults {
            let category = category.map_or_else(String::new, |category| format!("{category:03}"));
            self.sample("faults_total", &[("category", &category), ("reason", reason)], count);
        }
        let skipped = tally.skipped.iter().map(|(category, count)| (format!("{category:03}"), count));
        self.by("blocks_skipped_total", "Blocks of categories that are not used", "category", skipped);
        let accepted = tally.accepted.iter().map(|(&sensor, count)| (name(sensor), count));
        self.by("reports_accepted_total", "Reports taken", "sensor", accepted);
        let shed = tally.shed.iter().map(|(&sensor, count)| (name(sensor), count));
        self.by("plots_shed_total", "Plots left out because a node could not keep up", "sensor", shed);
        let jumping = tally.jumping_tracks.iter().map(|(&sensor, count)| (name(sensor), count));
        self.by("jumping_tracks_total", "Radar tracks discarded: their numbers jump", "sensor", jumping);
        let service = tally.service.iter().map(|(&sensor, count)| (name(sensor), count));
        self.by("service_messages_total", "Service messages of radars", "sensor", service);
        self.family("records_refused_total", "Records that gave no report");
        for ((sensor, reason), count) in &tally.refused {
            let labels = [("sensor", sensor.map_or("", name)), ("reason", *reason)];
            self.sample("records_refused_total", &labels, count);
        }
        let help = "Previously unknown identities reported by a transponder receiver, by what became of them";
        self.family("new_identities_total", help);
        for ((sensor, fate), count) in &tally.newcomers {
            self.sample("new_identities_total", &[("sensor", name(*sensor)), ("fate", *fate)], count);
        }
        let used = status.numbers_used as u64;
        let free = u64::from(LARGEST_TRANSPONDER_NUMBER).saturating_sub(used);
        self.one("transponder_numbers_used", "Transponder numbers in use", used);
        self.one("transponder_numbers_free", "Transponder numbers left", free);
        let unknown: u64 = tally.unknown_sources.values().sum();
        self.one("records_unknown_source_total", "Records of no configured sensor", unknown);
        if let Some(quantiles) = status.lateness_s {
            let help = "From when a slot was due to its publication, over the last minutes";
            self.family_of("summary", "lateness_seconds", help);
            for (quantile, seconds) in ["0.5", "0.95", "0.99"].into_iter().zip(quantiles) {
                self.sample("lateness_seconds", &[("quantile", quantile)], seconds);
            }
        }
    }
}
