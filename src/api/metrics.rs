//! `/metrics`: Prometheus text, written by hand: a line a number.

use std::fmt::{Display, Write};

use super::ask::{Answer, Ask, live};
use super::tls::Tls;
use crate::config::Config;
use crate::live::{Condition, Lateness, Level, LineStatus, SensorState, Status, values};
use crate::record::RecorderCounts;
use fusion::SensorIndex;
use fusion::numbering::LARGEST_TRANSPONDER_NUMBER;
use fusion::operational::Verdict;

const TEXT: &str = "text/plain; version=0.0.4; charset=utf-8";

/// All numbers.
pub fn text(ask: &Ask) -> Answer {
    let state = &ask.state;
    let hub = state.hub();
    let mut out = Metrics::default();
    out.family("utm_fusion_info", "gauge", "The running version");
    out.sample(
        "utm_fusion_info",
        &[("version", env!("CARGO_PKG_VERSION")), ("site", &hub.config.site.name)],
        1,
    );
    out.one("utm_fusion_start_time_seconds", "gauge", "When the service started", hub.started.as_seconds());
    let latest = state.log().latest().1;
    out.one(
        "utm_fusion_slots_published_total",
        "counter",
        "Slots put out",
        latest.as_ref().map_or(0, |s| s.frame.seq),
    );
    out.one("utm_fusion_tracks", "gauge", "Tracks in the latest slot", latest.map_or(0, |s| s.pieces.len()));
    out.one("utm_fusion_streams", "gauge", "Open event streams", state.seats().taken());
    out.one("utm_fusion_http_connections", "gauge", "Open HTTP connections", state.door().open());
    out.family(
        "utm_fusion_http_connections_refused_total",
        "counter",
        "Connections closed at once: address, one address has too many; full, there are too many in all; tls, no handshake",
    );
    for (reason, count) in state.door().refused() {
        out.sample("utm_fusion_http_connections_refused_total", &[("reason", reason.name())], count);
    }
    if let Some(expires) = state.terms().tls.as_ref().and_then(Tls::expires) {
        out.one(
            "utm_fusion_http_certificate_expires_seconds",
            "gauge",
            "When the TLS certificate expires, seconds since 1970",
            expires.as_seconds(),
        );
    }
    out.family("utm_fusion_http_responses_total", "counter", "HTTP responses by status");
    for (status, count) in state.answered() {
        out.sample("utm_fusion_http_responses_total", &[("status", &status.to_string())], count);
    }
    out.one(
        "utm_fusion_http_requests_limited_total",
        "counter",
        "Requests refused with 429 because an address or a token asked too often",
        state.limited(),
    );
    if let Some(history) = &state.options().history {
        out.one(
            "utm_fusion_history_failing",
            "gauge",
            "Whether the history cannot be written",
            u8::from(history.is_failing()),
        );
        out.one(
            "utm_fusion_history_lost_total",
            "counter",
            "Pictures missing in the history",
            history.lost(),
        );
    }
    let held = hub.decider.held();
    out.family("utm_fusion_decisions", "gauge", "Decisions of operators that are in force");
    for verdict in [Verdict::Correlated, Verdict::Decorrelated] {
        let count = held.iter().filter(|held| held.correlation.verdict == verdict).count();
        out.sample("utm_fusion_decisions", &[("verdict", verdict.name())], count);
    }
    out.condition(&state.condition(), hub.lateness());
    if let Some(recorded) = hub.recorded() {
        out.recording(recorded);
    }
    if let Some(status) = hub.status() {
        out.tally(&status, &hub.config);
        out.sensors(&status);
    }
    Ok(live(TEXT, out.0))
}

#[derive(Default)]
struct Metrics(String);

impl Metrics {
    fn family(&mut self, name: &str, kind: &str, help: &str) {
        // Writing to memory does not fail.
        let _ = writeln!(self.0, "# HELP {name} {help}.\n# TYPE {name} {kind}");
    }

    fn sample(&mut self, name: &str, labels: &[(&str, &str)], value: impl Display) {
        let label = |(name, value): &(&str, &str)| {
            let escaped = value.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
            format!("{name}=\"{escaped}\"")
        };
        let labels: Vec<String> = labels.iter().map(label).collect();
        let braces = if labels.is_empty() { String::new() } else { format!("{{{}}}", labels.join(",")) };
        let _ = writeln!(self.0, "{name}{braces} {value}");
    }

    fn one(&mut self, name: &str, kind: &str, help: &str, value: impl Display) {
        self.family(name, kind, help);
        self.sample(name, &[], value);
    }

    fn condition(&mut self, condition: &Condition, lateness: Option<Lateness>) {
        let level = match condition.level() {
            Level::NotReady => 0,
            Level::Degraded => 1,
            Level::Ok => 2,
        };
        self.one("utm_fusion_condition", "gauge", "0 not ready, 1 degraded, 2 ok", level);
        if let Some(lateness) = lateness {
            self.one(
                "utm_fusion_picture_late_seconds",
                "gauge",
                "How much later than configured the picture is, the most in the last 3 s; above 1 it is not ready",
                lateness.late.as_secs_f64(),
            );
        }
    }

    fn tally(&mut self, status: &Status, config: &Config) {
        let tally = &status.tally;
        let name =
            |index: SensorIndex| config.sensors.get(usize::from(index.0)).map_or("", |s| s.id.as_str());
        for (metric, help, value) in [
            ("utm_fusion_datagrams_received_total", "Datagrams received", tally.received),
            ("utm_fusion_received_bytes_total", "Octets received", tally.octets),
            ("utm_fusion_datagrams_duplicate_total", "Datagrams that came twice", tally.duplicates),
            ("utm_fusion_several_records_total", "CAT129 blocks with several records", tally.several_records),
            ("utm_fusion_restarts_total", "Fresh starts after a silence", tally.restarts),
            ("utm_fusion_clock_behind_total", "Steps back of the clock of reception", tally.clock_behind),
            ("utm_fusion_failed_sends_total", "Datagrams that could not be sent", status.failed_sends),
        ] {
            self.one(metric, "counter", help, value);
        }
        self.family("utm_fusion_faults_total", "counter", "Unreadable blocks and records");
        for ((category, reason), count) in &tally.faults {
            let category = category.map_or_else(String::new, |category| format!("{category:03}"));
            self.sample("utm_fusion_faults_total", &[("category", &category), ("reason", reason)], count);
        }
        self.family("utm_fusion_blocks_skipped_total", "counter", "Blocks of categories that are not used");
        for (category, count) in &tally.skipped {
            self.sample("utm_fusion_blocks_skipped_total", &[("category", &format!("{category:03}"))], count);
        }
        self.family("utm_fusion_reports_accepted_total", "counter", "Reports taken");
        for (&sensor, count) in &tally.accepted {
            self.sample("utm_fusion_reports_accepted_total", &[("sensor", name(sensor))], count);
        }
        self.family("utm_fusion_service_messages_total", "counter", "Service messages of radars");
        for (&sensor, count) in &tally.service {
            self.sample("utm_fusion_service_messages_total", &[("sensor", name(sensor))], count);
        }
        self.family("utm_fusion_records_refused_total", "counter", "Records that gave no report");
        for ((sensor, reason), count) in &tally.refused {
            let labels = [("sensor", sensor.map_or("", name)), ("reason", *reason)];
            self.sample("utm_fusion_records_refused_total", &labels, count);
        }
        self.family(
            "utm_fusion_new_identities_total",
            "counter",
            "Identities that a transponder receiver had not told of lately, by what became of them",
        );
        for ((sensor, fate), count) in &tally.newcomers {
            let labels = [("sensor", name(*sensor)), ("fate", *fate)];
            self.sample("utm_fusion_new_identities_total", &labels, count);
        }
        let used = status.numbers_used as u64;
        let free = u64::from(LARGEST_TRANSPONDER_NUMBER).saturating_sub(used);
        self.one("utm_fusion_transponder_numbers_used", "gauge", "Transponder numbers in use", used);
        self.one("utm_fusion_transponder_numbers_free", "gauge", "Transponder numbers left", free);
        let unknown: u64 = tally.unknown_sources.values().sum();
        self.one(
            "utm_fusion_records_unknown_source_total",
            "counter",
            "Records of no configured sensor",
            unknown,
        );
        if let Some(quantiles) = status.lateness_s {
            self.family(
                "utm_fusion_lateness_seconds",
                "summary",
                "From when a slot was due to its publication, over the last minutes",
            );
            for (quantile, seconds) in ["0.5", "0.95", "0.99"].into_iter().zip(quantiles) {
                self.sample("utm_fusion_lateness_seconds", &[("quantile", quantile)], seconds);
            }
        }
    }

    /// Angles in degrees, as an operator has them in the configuration.
    fn registrations(&mut self, status: &Status) {
        let known: Vec<_> = status
            .sensors
            .iter()
            .filter_map(|sensor| {
                let registration = sensor.registration.as_ref()?;
                Some((sensor.id.as_str(), registration, registration.estimate.as_ref()?))
            })
            .collect();
        if known.is_empty() {
            return;
        }
        let names = [
            ("bearing", "degrees"),
            ("tilt_east", "degrees"),
            ("tilt_north", "degrees"),
            ("range", "metres"),
            ("height", "metres"),
            ("time", "seconds"),
        ];
        for (index, (name, unit)) in names.into_iter().enumerate() {
            let family = format!("utm_fusion_registration_{name}_{unit}");
            self.family(&family, "gauge", "A radar's bias, measured minus true");
            for (sensor, _, estimate) in &known {
                self.sample(&family, &[("sensor", sensor)], values(estimate)[index].2.value);
            }
            let family = format!("utm_fusion_registration_{name}_deviation_{unit}");
            self.family(&family, "gauge", "One standard deviation of it");
            for (sensor, _, estimate) in &known {
                self.sample(&family, &[("sensor", sensor)], values(estimate)[index].2.deviation);
            }
        }
        self.family("utm_fusion_registration_observable", "gauge", "Whether a bias is known well enough");
        for (sensor, _, estimate) in &known {
            for ((name, _), (.., value)) in names.into_iter().zip(values(estimate)) {
                let labels = [("sensor", *sensor), ("value", name)];
                self.sample("utm_fusion_registration_observable", &labels, u8::from(value.observable));
            }
        }
        self.family("utm_fusion_registration_tracks", "gauge", "Radar tracks that it rests upon");
        for (sensor, _, estimate) in &known {
            self.sample("utm_fusion_registration_tracks", &[("sensor", sensor)], estimate.samples);
        }
        self.family("utm_fusion_registration_residual", "gauge", "1 as the configured errors let expect");
        for (sensor, _, estimate) in &known {
            if let Some(residual) = estimate.residual {
                self.sample("utm_fusion_registration_residual", &[("sensor", sensor)], residual);
            }
        }
        self.family("utm_fusion_registration_applied", "gauge", "Whether plots are put right by it");
        for (sensor, registration, _) in &known {
            let applied = u8::from(registration.is_applied());
            self.sample("utm_fusion_registration_applied", &[("sensor", sensor)], applied);
        }
        self.family("utm_fusion_registration_steps_total", "counter", "Times that it has begun anew");
        for (sensor, registration, _) in &known {
            self.sample("utm_fusion_registration_steps_total", &[("sensor", sensor)], registration.steps);
        }
    }

    fn recording(&mut self, recording: RecorderCounts) {
        let RecorderCounts { written, unwritten, lost, failing } = recording;
        self.one("utm_fusion_recorder_failing", "gauge", "Whether the disk fails", u8::from(failing));
        for (metric, help, value) in [
            ("utm_fusion_recorded_total", "Datagrams recorded", written),
            ("utm_fusion_recorder_unwritten_total", "Datagrams not recorded: the disk failed", unwritten),
            ("utm_fusion_recorder_lost_total", "Datagrams not recorded: the recorder did not keep up", lost),
        ] {
            self.one(metric, "counter", help, value);
        }
    }

    fn sensors(&mut self, status: &Status) {
        self.family("utm_fusion_sensor_state", "gauge", "0 outage, 1 degraded, 2 operational");
        for sensor in &status.sensors {
            let state = match sensor.state {
                SensorState::Outage => 0,
                SensorState::Degraded => 1,
                SensorState::Operational => 2,
            };
            self.sample("utm_fusion_sensor_state", &[("sensor", &sensor.id)], state);
        }
        self.family("utm_fusion_sensor_rate_hertz", "gauge", "Reports a second over the last 10 s");
        for sensor in &status.sensors {
            self.sample("utm_fusion_sensor_rate_hertz", &[("sensor", &sensor.id)], sensor.rate_hz);
        }
        self.family("utm_fusion_sensor_clock_offset_seconds", "gauge", "Least delay of the last reports");
        for sensor in &status.sensors {
            if let Some(offset_s) = sensor.clock_offset_s {
                self.sample("utm_fusion_sensor_clock_offset_seconds", &[("sensor", &sensor.id)], offset_s);
            }
        }
        self.registrations(status);
        // Sensors may share a line: each line once.
        let mut lines: Vec<&LineStatus> = status.sensors.iter().flat_map(|sensor| &sensor.lines).collect();
        lines.sort_by(|a, b| a.name.cmp(&b.name));
        lines.dedup_by(|a, b| a.name == b.name);
        type Count = fn(&LineStatus) -> u64;
        let counts: [(&str, &str, &str, Count); 6] = [
            ("utm_fusion_line_joined", "gauge", "Whether the line is open", |line| u64::from(line.joined)),
            ("utm_fusion_line_received_total", "counter", "Datagrams", |line| line.received),
            ("utm_fusion_line_duplicate_total", "counter", "Copies of another line's", |line| {
                line.duplicates
            }),
            ("utm_fusion_line_foreign_total", "counter", "Datagrams of other hosts", |line| line.foreign),
            ("utm_fusion_line_queue_full_total", "counter", "Datagrams lost in the queue", |line| {
                line.queue_full
            }),
            ("utm_fusion_line_kernel_dropped_total", "counter", "Datagrams lost in the kernel", |line| {
                line.kernel_dropped
            }),
        ];
        for (name, kind, help, count) in counts {
            self.family(name, kind, help);
            for line in &lines {
                self.sample(name, &[("line", &line.name)], count(line));
            }
        }
    }
}
