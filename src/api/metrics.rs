//! `/metrics`: Prometheus text, a line per number.
//!
//! Written by hand: the crate `prometheus-client` knows no summary and would name counters otherwise.

use std::fmt::{Display, Write};
use std::sync::Arc;

use super::ask::{Answer, Ask, live};
use super::shown::Shown;
use super::tls::Tls;
use crate::config::Config;
use crate::live::{
    Integrities, Level, LineStatus, RegistrationStatus, SensorState, SensorStatus, Status, of_data_sheet,
    type_name, values, velocity_errors, verdict_name,
};
use fusion::SensorIndex;
use fusion::integrity::{Reason, State};
use fusion::learning::{LearntType, LearntValue};
use fusion::numbering::LARGEST_TRANSPONDER_NUMBER;
use fusion::operational::Verdict;
use fusion::registration::Misalignment;

pub const TEXT: &str = "text/plain; version=0.0.4; charset=utf-8";

/// All numbers.
pub fn text(ask: &Ask) -> Answer {
    let state = &ask.state;
    let hub = &state.hub;
    let latest = state.log.latest().1;
    let mut out = Metrics::default();
    out.family("info", "The running version");
    out.sample("info", &[("version", env!("CARGO_PKG_VERSION")), ("site", &hub.config.site.name)], 1);
    out.one("start_time_seconds", "When the service started", hub.started.as_seconds());
    out.one("slots_published_total", "Slots published", latest.as_ref().map_or(0, |shown| shown.frame.seq));
    out.one("tracks", "Tracks in the latest slot", latest.as_ref().map_or(0, |shown| shown.usual().count()));
    out.one("streams", "Open event streams", state.seats.taken());
    out.one("http_connections", "Open HTTP connections", state.door.open());
    out.by(
        "http_connections_refused_total",
        "Connections closed at once: address, one address has too many; full, there are too many in all; tls, no handshake",
        "reason",
        state.door.refused().map(|(reason, count)| (reason.name(), count)),
    );
    if let Some(expires) = state.terms().tls.as_ref().and_then(Tls::expires) {
        let help = "When the TLS certificate expires, seconds since 1970";
        out.one("http_certificate_expires_seconds", help, expires.as_seconds());
    }
    out.by("http_responses_total", "HTTP responses by status", "status", state.answered());
    let help = "Requests refused with 429 because an address or a token asked too often";
    out.one("http_requests_limited_total", help, state.limited());
    if let Some(history) = &state.options.history {
        out.one("history_failing", "Whether the history cannot be written", u8::from(history.is_failing()));
        out.one("history_lost_total", "Pictures missing in the history", history.lost());
    }
    let held = hub.decider.held();
    let in_force = |verdict| held.iter().filter(|held| held.correlation.verdict == verdict).count();
    let verdicts =
        [Verdict::Correlated, Verdict::Decorrelated].map(|verdict| (verdict.name(), in_force(verdict)));
    out.by("decisions", "Correlations decided by operators that are in force", "verdict", verdicts);
    out.integrity(&hub.integrity.held());
    let uncooperative =
        |shown: &Arc<Shown>| shown.frame.picture.tracks.iter().filter(|track| track.is_uncooperative).count();
    let help = "Tracks in the latest slot that fly without a transponder where one would be heard";
    out.one("uncooperative", help, latest.as_ref().map_or(0, uncooperative));
    let level = match state.condition().level() {
        Level::NotReady => 0,
        Level::Degraded => 1,
        Level::Ok => 2,
    };
    out.one("condition", "0 not ready, 1 degraded, 2 ok", level);
    if let Some(lateness) = hub.lateness() {
        let help = "How much later than configured the picture is, the most in the last 3 s; above 1 it is not ready";
        out.one("picture_late_seconds", help, lateness.late.as_secs_f64());
    }
    if let Some(recorded) = hub.recorded() {
        out.one("recorder_failing", "Whether the disk fails", u8::from(recorded.failing));
        out.one("recorded_total", "Datagrams recorded", recorded.written);
        out.one("recorder_unwritten_total", "Datagrams not recorded: the disk failed", recorded.unwritten);
        out.one("recorder_lost_total", "Datagrams not recorded: the recorder did not keep up", recorded.lost);
    }
    if let Some(status) = hub.status() {
        out.tally(&status, &hub.config);
        out.sensors(&status.sensors);
        out.registrations(&status.sensors);
        out.learnt(&status.sensors);
        out.types(&status.sensors);
        out.lines(&status.sensors);
    }
    Ok(live(TEXT, out.0))
}

/// The text so far. Names stand here without `utm_fusion_`; what ends in `_total` is a counter, anything else a gauge.
#[derive(Default)]
struct Metrics(String);

impl Metrics {
    fn family(&mut self, name: &str, help: &str) {
        self.family_of(if name.ends_with("_total") { "counter" } else { "gauge" }, name, help);
    }

    fn family_of(&mut self, kind: &str, name: &str, help: &str) {
        // Writing to memory does not fail.
        let _ = writeln!(self.0, "# HELP utm_fusion_{name} {help}.\n# TYPE utm_fusion_{name} {kind}");
    }

    fn sample(&mut self, name: &str, labels: &[(&str, &str)], value: impl Display) {
        let label = |(name, value): &(&str, &str)| {
            let escaped = value.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
            format!("{name}=\"{escaped}\"")
        };
        let labels: Vec<String> = labels.iter().map(label).collect();
        let braces = if labels.is_empty() { String::new() } else { format!("{{{}}}", labels.join(",")) };
        let _ = writeln!(self.0, "utm_fusion_{name}{braces} {value}");
    }

    /// A family of one number.
    fn one(&mut self, name: &str, help: &str, value: impl Display) {
        self.family(name, help);
        self.sample(name, &[], value);
    }

    /// A family of a number per value of a label.
    fn by<L: Display, V: Display>(
        &mut self,
        name: &str,
        help: &str,
        label: &str,
        samples: impl IntoIterator<Item = (L, V)>,
    ) {
        self.family(name, help);
        for (value, number) in samples {
            self.sample(name, &[(label, &value.to_string())], number);
        }
    }

    /// Whether transponders can be trusted.
    fn integrity(&mut self, known: &Integrities) {
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

    fn sensors(&mut self, sensors: &[SensorStatus]) {
        let state = |sensor: &SensorStatus| match sensor.state {
            SensorState::Outage => 0,
            SensorState::Degraded => 1,
            SensorState::Operational => 2,
        };
        let states = sensors.iter().map(|sensor| (&sensor.id, state(sensor)));
        self.by("sensor_state", "0 outage, 1 degraded, 2 operational", "sensor", states);
        let rates = sensors.iter().map(|sensor| (&sensor.id, sensor.rate_hz));
        self.by("sensor_rate_hertz", "Reports per second over the last 10 s", "sensor", rates);
        let offsets = sensors.iter().filter_map(|sensor| Some((&sensor.id, sensor.clock_offset_s?)));
        self.by("sensor_clock_offset_seconds", "Least delay of the last reports", "sensor", offsets);
    }

    /// Angles in degrees, as an operator has them in the configuration.
    fn registrations(&mut self, sensors: &[SensorStatus]) {
        let known: Vec<_> = sensors.iter().filter_map(registered).collect();
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
            let estimated = || known.iter().map(|(id, _, estimate)| (id, values(estimate)[index].2));
            let biases = estimated().map(|(id, value)| (id, value.value));
            let help = "A radar's bias, measured minus true";
            self.by(&format!("registration_{name}_{unit}"), help, "sensor", biases);
            let deviations = estimated().map(|(id, value)| (id, value.deviation));
            let help = "Standard deviation of the bias";
            self.by(&format!("registration_{name}_deviation_{unit}"), help, "sensor", deviations);
        }
        self.family("registration_observable", "Whether a bias is known well enough");
        for (sensor, _, estimate) in &known {
            for ((name, _), (.., value)) in names.into_iter().zip(values(estimate)) {
                let labels = [("sensor", sensor.as_str()), ("value", name)];
                self.sample("registration_observable", &labels, u8::from(value.observable));
            }
        }
        let tracks = known.iter().map(|(id, _, estimate)| (id, estimate.samples));
        self.by("registration_tracks", "Radar tracks that it rests upon", "sensor", tracks);
        let residuals = known.iter().filter_map(|(id, _, estimate)| Some((id, estimate.residual?)));
        self.by("registration_residual", "1: as the configured errors predict", "sensor", residuals);
        let applied = known.iter().map(|(id, registration, _)| (id, u8::from(registration.is_applied())));
        self.by("registration_applied", "Whether plots are corrected by it", "sensor", applied);
        let steps = known.iter().map(|(id, registration, _)| (id, registration.steps));
        self.by("registration_steps_total", "Times that it has begun anew", "sensor", steps);
    }

    /// What was learnt of the radars' errors.
    fn learnt(&mut self, sensors: &[SensorStatus]) {
        let learnt =
            |sensor: &'_ SensorStatus| Some((sensor.id.clone(), sensor.registration.as_ref()?.learnt?));
        let known: Vec<_> = sensors.iter().filter_map(learnt).collect();
        if known.is_empty() {
            return;
        }
        type Part = fn(&LearntValue) -> f64;
        let parts: [(&str, &str, Part); 2] = [
            ("learnt_of_data_sheet", "A radar's errors over those of its data sheet", |value| value.value),
            ("learnt_of_data_sheet_deviation", "Standard deviation of that", |value| value.deviation),
        ];
        for (name, help, part) in parts {
            self.family(name, help);
            for (sensor, learnt) in &known {
                for (axis, value) in of_data_sheet(learnt) {
                    self.sample(name, &[("sensor", sensor.as_str()), ("axis", axis)], part(&value));
                }
            }
        }
        let tracks = known.iter().map(|(id, learnt)| (id, learnt.azimuth.tracks));
        self.by("learnt_tracks", "Independent samples that it rests upon", "sensor", tracks);
        let used = known.iter().map(|(id, learnt)| (id, u8::from(verdict_name(&learnt.velocity) == "used")));
        self.by("learnt_velocity_used", "Whether a radar's velocities are used", "sensor", used);
        let off =
            known.iter().filter_map(|(id, learnt)| Some((id, velocity_errors(&learnt.velocity)?.sigma_m_s)));
        self.by("learnt_velocity_error_metres_per_second", "How far they are off, each axis", "sensor", off);
    }

    /// What was learnt of the types of transponders.
    fn types(&mut self, sensors: &[SensorStatus]) {
        type Part = (&'static str, fn(&LearntType) -> f64);
        let families: [(&str, &str, &[Part]); 2] = [
            (
                "learnt_transponder_noise_metres",
                "White noise of a type of transponders, each axis",
                &[
                    ("horizontal", |learnt| learnt.horizontal_m.value),
                    ("vertical", |learnt| learnt.vertical_m.value),
                ],
            ),
            (
                "learnt_transponder_delay_seconds",
                "How late the times of a type of transponders are",
                &[
                    ("value", |learnt| learnt.delay_s.value),
                    ("deviation", |learnt| learnt.delay_s.deviation),
                    ("applied", |learnt| learnt.applied_s),
                ],
            ),
        ];
        if sensors.iter().all(|sensor| sensor.types.is_empty()) {
            return;
        }
        for (name, help, parts) in families {
            self.family(name, help);
            for sensor in sensors {
                for (kind, learnt) in &sensor.types {
                    for (part, number) in parts {
                        let labels =
                            [("sensor", sensor.id.as_str()), ("type", &type_name(kind)), ("part", part)];
                        self.sample(name, &labels, number(learnt));
                    }
                }
            }
        }
    }

    /// Sensors may share a line: each line once.
    fn lines(&mut self, sensors: &[SensorStatus]) {
        let mut lines: Vec<&LineStatus> = sensors.iter().flat_map(|sensor| &sensor.lines).collect();
        lines.sort_by(|a, b| a.name.cmp(&b.name));
        lines.dedup_by(|a, b| a.name == b.name);
        type Count = fn(&LineStatus) -> u64;
        let counts: [(&str, &str, Count); 6] = [
            ("line_joined", "Whether the line is open", |line| u64::from(line.joined)),
            ("line_received_total", "Datagrams", |line| line.received),
            ("line_duplicate_total", "Copies of another line's", |line| line.duplicates),
            ("line_foreign_total", "Datagrams of other hosts", |line| line.foreign),
            ("line_queue_full_total", "Datagrams lost in the queue", |line| line.queue_full),
            ("line_kernel_dropped_total", "Datagrams lost in the kernel", |line| line.kernel_dropped),
        ];
        for (name, help, count) in counts {
            self.by(name, help, "line", lines.iter().map(|line| (&line.name, count(line))));
        }
    }
}

/// A sensor whose registration is estimated: its id, and what is known.
fn registered(sensor: &SensorStatus) -> Option<(&String, &RegistrationStatus, &Misalignment)> {
    let registration = sensor.registration.as_ref()?;
    Some((&sensor.id, registration, registration.estimate.as_ref()?))
}
