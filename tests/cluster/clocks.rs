//! Gateways whose clocks are wrong (libfaketime), or reported as wrong by a substitute of `chronyc`.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use fusion::Identity;
use jiff::SignedDuration;
use serde_json::Value;
use utm_fusion::cluster::{CellOutput, GatewayReport, Log, WHOLE, pictures};
use utm_fusion::picture::{Picture, PictureTrack};

use crate::site::{GATEWAYS, GOOD_CLOCK, LOST_CLOCK, SLACK_S, Setup, Site, until, variable};

/// Region of a single process with a right clock.
const ALONE: &str = "alone";

/// Path of the library that shifts a process's clock; `None`, with a message, if it is not installed.
pub fn faketime() -> Option<PathBuf> {
    let named = std::env::var_os("UTM_FUSION_FAKETIME").map(PathBuf::from);
    let machine = std::env::consts::ARCH;
    let usual = ["libfaketimeMT.so.1", "libfaketime.so.1"].into_iter().flat_map(|name| {
        [format!("/usr/lib/{machine}-linux-gnu/faketime/{name}"), format!("/usr/lib64/faketime/{name}")]
    });
    let found = named.or_else(|| usual.map(PathBuf::from).find(|path| path.exists()));
    if found.is_none() {
        println!("skipped: no libfaketime");
    }
    found
}

/// Texts of the active alerts about clocks.
async fn alerts(site: &Site) -> Option<Vec<String>> {
    let (_, alerts) = site.ask("/api/v1/alerts").await?;
    let is_of_clocks = |alert: &&Value| {
        alert["part"].as_str().is_some_and(|part| part.starts_with("cluster clock"))
            && alert.get("until").is_none()
    };
    let alerts = alerts["alerts"].as_array()?.iter().filter(is_of_clocks);
    Some(alerts.filter_map(|alert| alert["text"].as_str().map(str::to_owned)).collect())
}

/// Difference of the gateways' clocks as shown on the map, in seconds.
async fn difference_s(site: &Site) -> Option<f64> {
    site.ask("/api/v1/cluster").await?.1["clocks"][0]["difference_s"].as_f64()
}

/// Outputs published from now on, by slot.
async fn published(log: &Log, slots: usize) -> BTreeMap<i64, Picture> {
    let (last, _) = until("an output", async || log.last(WHOLE).await.ok().flatten()).await;
    let mut outputs = log.outputs(WHOLE, last + 1);
    let mut found = BTreeMap::new();
    while found.len() < slots {
        let next = tokio::time::timeout(Duration::from_secs(60), outputs.next()).await.expect("slots come");
        let output = CellOutput::parse(&next.expect("the stream is there").1).unwrap();
        found.insert(output.slot.0, pictures(&output.picture).unwrap().0);
    }
    found
}

/// Differences between two clusters with the same sensor data, aircraft by aircraft.
#[derive(Default)]
struct PictureDifference {
    /// Number of pairs of aircraft and slot in both, and of those with identical position and estimate.
    both: usize,
    equal: usize,
    /// Numbers of those in only one of them.
    lost: usize,
    besides: usize,
    /// Distances between their positions, in metres.
    distances_m: Vec<f64>,
}

impl PictureDifference {
    fn of(right: &BTreeMap<i64, Picture>, found: &BTreeMap<i64, Picture>) -> Self {
        let mut compared = Self::default();
        for (slot, right) in right {
            let Some(found) = found.get(slot) else { continue };
            let mut left: Vec<_> = found.tracks.iter().collect();
            for track in &right.tracks {
                let place = |track: &PictureTrack| track.point.position.0;
                let identity = |track: &PictureTrack| -> Option<Identity> {
                    track.point.source.transponder().map(|part| part.identity)
                };
                // Track numbers of radar-only aircraft differ between nodes: match the nearest one.
                let distance_m = |other: &PictureTrack| (place(other) - place(track)).norm();
                let same = left.iter().enumerate().filter(|(_, other)| identity(other) == identity(track));
                let nearest = same.min_by(|a, b| distance_m(a.1).total_cmp(&distance_m(b.1)));
                let Some((index, _)) = nearest.filter(|(_, other)| distance_m(other) < 50.0) else {
                    compared.lost += 1;
                    continue;
                };
                let other = left.swap_remove(index);
                compared.both += 1;
                compared.equal += usize::from(
                    other.point.position == track.point.position
                        && other.point.estimate == track.point.estimate,
                );
                compared.distances_m.push(distance_m(other));
            }
            compared.besides += left.len();
        }
        compared.distances_m.sort_by(f64::total_cmp);
        compared
    }

    fn at_m(&self, share: f64) -> f64 {
        self.distances_m[((self.distances_m.len() - 1) as f64 * share) as usize]
    }
}

impl fmt::Display for PictureDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { both, equal, lost, besides, distances_m } = self;
        let [p50_m, p99_m, max_m] = [0.5, 0.99, 1.0].map(|share| self.at_m(share));
        let far = distances_m.iter().filter(|distance_m| **distance_m > 0.01).count();
        write!(
            f,
            "{equal} of {both} equal to the bit, {lost} lost, {besides} besides; positions: p50 {p50_m:.6} m, p99 {p99_m:.6} m, max {max_m:.3} m, {far} farther than 1 cm"
        )
    }
}

/// `UTM_FUSION_CLOCK_MS` is the clock's error; `UTM_FUSION_COMPARED` is the number of slots compared.
#[tokio::test(flavor = "multi_thread")]
async fn differing_gateway_clocks_are_reported_and_harmless() {
    let Some(library) = faketime() else { return };
    let off_ms = variable("UTM_FUSION_CLOCK_MS", 50.0);
    let slots = variable("UTM_FUSION_COMPARED", 40.0) as usize;
    let setup = Setup { shifted: Some((GATEWAYS[1], library)), ..Setup::default() };
    let Some(mut site) = Site::start(setup).await else { return };
    let alone = site.beside(ALONE).await;
    until("the one that is alone", async || alone.last(WHOLE).await.ok().flatten()).await;
    // After the longest memory of an engine both have the same knowledge.
    tokio::time::sleep(Duration::from_secs(30)).await;
    let difference = until("a difference", async || difference_s(&site).await).await;
    assert!(difference.abs() < 0.015, "{difference}");
    assert_eq!(alerts(&site).await.unwrap(), Vec::<String>::new());
    let status = site.command(&["status"]).await;
    let text = String::from_utf8(status.stdout).unwrap();
    println!("{text}");
    assert!(text.contains("±3.0 ms") && text.contains(" ms from g1"), "{text}");
    let compare = async || {
        let (right, found) = tokio::join!(published(&alone, slots), published(&site.log, slots));
        let compared = PictureDifference::of(&right, &found);
        println!("{compared}");
        compared
    };
    println!("both right:");
    let compared = compare().await;
    // Some differ: data just in time for one may have been late for the other.
    assert!(compared.both > slots && compared.lost + compared.besides < slots / 10, "{compared}");
    // They started at different times, so the learned sensor values differ slightly.
    assert!(compared.at_m(0.9) < 0.3, "{compared}");

    site.shift(GATEWAYS[1], SignedDuration::from_micros((off_ms * 1e3) as i64));
    let began = Instant::now();
    let text = until("an alert", async || alerts(&site).await?.into_iter().next()).await;
    println!("alert after {:.1} s: {text}", began.elapsed().as_secs_f64());
    assert!(text.contains("gateways g0 and g1 differ by"), "{text}");
    let difference = until("the difference", async || {
        difference_s(&site).await.filter(|found| (found.abs() * 1e3 - off_ms.abs()).abs() < 15.0)
    })
    .await;
    // The sign is that of the second gateway's delay relative to the first, by name.
    assert!(difference * off_ms < 0.0, "{difference}");
    let (_, status) = site.ask("/api/v1/status").await.unwrap();
    assert_eq!(status["state"], "degraded", "{status}");
    let status = site.command(&["status", "--json"]).await;
    assert_eq!(status.status.code(), Some(1));
    let json: Value = serde_json::from_slice(&status.stdout).unwrap();
    assert!(json["wrong"][0].as_str().unwrap().contains("g0 and g1 differ"), "{json}");
    tokio::time::sleep(Duration::from_secs(10)).await;
    println!("one is {off_ms} ms off:");
    let compared = compare().await;
    assert!(compared.both > slots && compared.lost + compared.besides < slots, "{compared}");

    site.shift(GATEWAYS[1], SignedDuration::ZERO);
    let began = Instant::now();
    until("no alert", async || alerts(&site).await?.is_empty().then_some(())).await;
    println!("none after {:.1} s", began.elapsed().as_secs_f64());
}

/// Number of messages that a gateway has sent by its report: those in the log, and those waiting.
const fn handed_on(report: &GatewayReport) -> u64 {
    report.counts.written + report.counts.waiting
}

/// Whether a gateway sends messages within some seconds.
async fn writes(site: &Site, gateway: &str) -> bool {
    let report = async || site.gateway(gateway).await;
    let before = until("its word", report).await;
    tokio::time::sleep(Duration::from_secs(4)).await;
    handed_on(&until("its word", report).await) > handed_on(&before)
}

/// Waits until a gateway has reported silence for some seconds without a break. On a busy machine the other gateway's report may
/// be late, and this one publishes for a moment. While silent it sends nothing, and counts what it receives.
async fn stays_silent(site: &Site, gateway: &str) {
    until("silence without a break", async || {
        let before = is_silent(site, gateway, true).await;
        tokio::time::sleep(Duration::from_secs(4)).await;
        let after = site.gateway(gateway).await?;
        if !after.clock.is_silent || after.counts.resumed > before.counts.resumed {
            println!("silence had a break: {:?}, {:?}", before.counts, after.counts);
            return None;
        }
        assert_eq!(handed_on(&after), handed_on(&before), "{after:?}");
        assert!(
            after.counts.withheld > before.counts.withheld && !after.recent_datagrams.is_empty(),
            "{after:?}"
        );
        Some(())
    })
    .await;
}

/// Waits until a gateway is silent or publishes. Returns its report.
async fn is_silent(site: &Site, gateway: &str, silent: bool) -> GatewayReport {
    let what = if silent { "it is silent" } else { "it speaks" };
    until(what, async || site.gateway(gateway).await.filter(|report| report.clock.is_silent == silent)).await
}

#[tokio::test(flavor = "multi_thread")]
async fn unsynchronised_gateway_is_silent_while_another_is_fit() {
    let Some(mut site) = Site::start(Setup::default()).await else { return };
    let watcher = site.watch().await;
    let [carries, lost] = GATEWAYS;
    site.clock(lost, LOST_CLOCK);
    let began = Instant::now();
    let unsynchronised = async || {
        let report: GatewayReport = site.gateway(lost).await?;
        (report.clock.state.is_synchronised == Some(false)).then_some(report)
    };
    let report = until("it knows", unsynchronised).await;
    assert!(!report.clock.is_silent);
    tokio::time::sleep(Duration::from_secs(45)).await;
    assert!(writes(&site, lost).await, "not yet");
    let report = is_silent(&site, lost, true).await;
    println!("silent after {:.1} s: {:?}", began.elapsed().as_secs_f64(), report.counts);
    until("an alert", async || {
        let alerts = alerts(&site).await?;
        alerts.iter().any(|text| text.contains("g1 is not synchronised: it publishes nothing")).then_some(())
    })
    .await;
    stays_silent(&site, lost).await;
    assert!(site.log_text(lost).contains("publishes nothing"), "{}", site.log_text(lost));

    // The other gateway is gone: wrong timestamps are better than no data.
    let before = watcher.slots();
    site.kill(carries);
    let began = Instant::now();
    is_silent(&site, lost, false).await;
    println!("speaks {:.1} s after the other one was killed", began.elapsed().as_secs_f64());
    until("an alert that is worse", async || {
        let alerts = alerts(&site).await?;
        alerts.iter().any(|text| text.contains("no other gateway carries")).then_some(())
    })
    .await;
    watcher.more(20).await;
    println!("silence of slots meanwhile {:.2} s", watcher.silence_s(before));
    site.run(carries);
    is_silent(&site, lost, true).await;
    site.clock(lost, GOOD_CLOCK);
    is_silent(&site, lost, false).await;
    assert!(writes(&site, lost).await);
    until("no alert", async || alerts(&site).await?.is_empty().then_some(())).await;
    let summary = watcher.checked().await;
    println!("{summary:?}");
    assert!(summary.silence_s < SLACK_S, "{summary:?}");
}
