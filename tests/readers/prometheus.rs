//! `docker/monitoring`: promtool checks the rules, and a Prometheus that reads the demo evaluates all expressions of rules and
//! dashboard.

use std::collections::BTreeSet;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::program::Scratch;
use crate::service::{Demo, Ending, get, is_installed, try_get, until};

/// Metrics that the demo lacks, because it has no recording, history, sinks or TLS, and no lasting registration of a radar.
const ELSEWHERE: [&str; 16] = [
    "utm_fusion_history_failing",
    "utm_fusion_history_lost_total",
    "utm_fusion_http_certificate_expires_seconds",
    "utm_fusion_learnt_of_data_sheet",
    "utm_fusion_notices_failing",
    "utm_fusion_notices_lost_total",
    "utm_fusion_recorded_total",
    "utm_fusion_recorder_failing",
    "utm_fusion_recorder_lost_total",
    "utm_fusion_recorder_unwritten_total",
    "utm_fusion_registration_bearing_degrees",
    "utm_fusion_registration_steps_total",
    "utm_fusion_sink_failing",
    "utm_fusion_sink_seconds_lost_total",
    "utm_fusion_state_damaged_total",
    "utm_fusion_state_failing",
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docker/monitoring")
}

fn promtool(arguments: &[&str]) {
    let output = Command::new("promtool").args(arguments).current_dir(folder()).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&said));
}

#[test]
fn each_rule_fires_exactly_when_due() {
    if !is_installed("promtool", "--version") {
        return;
    }
    promtool(&["check", "rules", "alerts.yml"]);
    promtool(&["check", "config", "prometheus.yml"]);
    promtool(&["test", "rules", "alerts.test.yml"]);
}

#[test]
fn each_rule_is_tested() {
    let [rules, tests] =
        ["alerts.yml", "alerts.test.yml"].map(|name| std::fs::read_to_string(folder().join(name)).unwrap());
    let names = |text: &str, before: &str| -> BTreeSet<String> {
        text.split(before).skip(1).map(|rest| rest.split(['\n', '"']).next().unwrap().to_owned()).collect()
    };
    assert_eq!(names(&rules, "- alert: "), names(&tests, "alertname=\""));
}

#[test]
fn compose_mounts_files_that_are_there() {
    let compose = std::fs::read_to_string(folder().join("../compose.yml")).unwrap();
    let mounted: Vec<&str> =
        compose.split("- ./monitoring/").skip(1).map(|rest| rest.split(':').next().unwrap()).collect();
    assert!(mounted.len() >= 5, "{mounted:?}");
    mounted.iter().for_each(|path| assert!(folder().join(path).is_file(), "{path}"));
}

/// Starts a Prometheus with the bundled configuration, except for the address of the service and the interval.
fn prometheus(scratch: &Scratch, service: SocketAddr) -> (Ending, SocketAddr) {
    let mut config = std::fs::read_to_string(folder().join("prometheus.yml")).unwrap();
    for (written, here) in [("127.0.0.1:8080", &*service.to_string()), ("_interval: 5s", "_interval: 1s")] {
        assert!(config.contains(written), "{written}");
        config = config.replace(written, here);
    }
    let config = scratch.file("prometheus.yml", config);
    std::fs::copy(folder().join("alerts.yml"), scratch.path("alerts.yml")).unwrap();
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let child = Command::new("prometheus")
        .arg(format!("--config.file={}", config.display()))
        .arg(format!("--storage.tsdb.path={}", scratch.path("data").display()))
        .arg(format!("--web.listen-address={address}"))
        .args(["--log.level=warn"])
        .stdin(Stdio::null())
        .spawn()
        .unwrap();
    (Ending(child), address)
}

/// Result of an expression: a list of samples.
fn query(prometheus: SocketAddr, expression: &str) -> Vec<Value> {
    let encoded: String = form_urlencoded::byte_serialize(expression.as_bytes()).collect();
    let answer = try_get(prometheus, &format!("/api/v1/query?query={encoded}"));
    let answer = answer.unwrap_or_else(|answer| panic!("{expression}: {answer}"));
    let answer: Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(answer["status"], "success", "{expression}: {answer}");
    answer["data"]["result"].as_array().unwrap_or_else(|| panic!("{expression}: {answer}")).clone()
}

/// Expressions of the dashboard, with Grafana's variables replaced.
fn dashboard() -> Vec<String> {
    let text = std::fs::read_to_string(folder().join("dashboard.json")).unwrap();
    let board: Value = serde_json::from_str(&text).unwrap();
    let panels = board["panels"].as_array().unwrap().iter().filter(|panel| panel["type"] != "row");
    let targets = panels.flat_map(|panel| {
        let targets = panel["targets"].as_array().unwrap();
        assert!(!targets.is_empty(), "{panel}");
        targets
    });
    let put = |target: &Value| {
        let text = target["expr"].as_str().unwrap();
        let text =
            text.replace("$instance", ".*").replace("$__rate_interval", "10s").replace("$__range", "1m");
        assert!(!text.contains('$'), "{text}");
        text
    };
    targets.map(put).collect()
}

/// Metrics used by an expression.
fn metrics(expression: &str) -> BTreeSet<String> {
    let words = expression.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    words
        .filter(|word| word.starts_with("utm_fusion_") || word.starts_with("process_"))
        .map(str::to_owned)
        .collect()
}

/// Names of the samples.
fn samples(text: &str) -> BTreeSet<&str> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.split(['{', ' ']).next().unwrap()).collect()
}

#[test]
fn prometheus_evaluates_every_expression() {
    if !is_installed("prometheus", "--version") {
        return;
    }
    let (scratch, demo) = (Scratch::new(), Demo::start());
    // Metrics that exist before the first scrape are included in it.
    let first = get(demo.address, "/metrics");
    let there = samples(&first);
    let (_process, prometheus) = prometheus(&scratch, demo.address);
    until("Prometheus is ready", || try_get(prometheus, "/-/ready").is_ok());
    until("rates of some seconds", || {
        !query(prometheus, "count_over_time(utm_fusion_tracks[20s]) > 8").is_empty()
    });
    assert_eq!(query(prometheus, "up{job=\"utm-fusion\"} == 1").len(), 1);

    let text = get(demo.address, "/metrics");
    let families = text.lines().filter_map(|line| line.strip_prefix("# HELP ")?.split(' ').next());
    let known: BTreeSet<&str> = families.chain(samples(&text)).chain(ELSEWHERE).collect();
    let is_known = |expression: &str| {
        metrics(expression).iter().for_each(|name| {
            assert!(known.contains(&**name), "no such metric: {name} in {expression}");
        });
    };

    for expression in dashboard() {
        is_known(&expression);
        let found = query(prometheus, &expression);
        // A comparison returns only samples above the bound.
        let is_there = metrics(&expression).iter().all(|name| there.contains(&**name));
        assert!(!is_there || !found.is_empty() || expression.contains('>'), "{expression}");
    }

    let rules = || -> Vec<Value> {
        let answer: Value = serde_json::from_str(&get(prometheus, "/api/v1/rules")).unwrap();
        let groups = answer["data"]["groups"].as_array().unwrap();
        groups.iter().flat_map(|group| group["rules"].as_array().unwrap()).cloned().collect()
    };
    until("every rule is evaluated", || rules().iter().all(|rule| rule["health"] != "unknown"));
    let rules = rules();
    assert!(rules.len() > 25, "{}", rules.len());
    for rule in &rules {
        assert_eq!(rule["health"], "ok", "{rule}");
        is_known(rule["query"].as_str().unwrap());
    }
}
