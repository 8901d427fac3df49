//! Loss of a cell's owner: another node takes over after a short silence.

use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use utm_fusion::cluster::{AppendResult, CellOutput, WHOLE};

use crate::site::{LEASE_S, NODES, SLACK_S, Setup, Site, until, variable};

/// Kills `UTM_FUSION_TAKEOVERS` owners, with leases of `UTM_FUSION_LEASE` seconds.
#[tokio::test(flavor = "multi_thread")]
async fn killed_owner_is_replaced_at_any_time() {
    let count = variable("UTM_FUSION_TAKEOVERS", 3.0) as usize;
    let lease_s = variable("UTM_FUSION_LEASE", LEASE_S);
    let Some(mut site) = Site::start(Setup { lease_s, ..Setup::default() }).await else { return };
    let seed = variable("UTM_FUSION_SEED", 1.0) as u64;
    let mut moments = ChaCha8Rng::seed_from_u64(seed);
    let watcher = site.watch().await;
    let mut silences = Vec::new();
    for _ in 0..count {
        let [owner, _] = site.pair().await;
        let held = site.owner().await.unwrap();
        tokio::time::sleep(Duration::from_millis(moments.random_range(0..1500))).await;
        let (before, began) = (watcher.slots(), Instant::now());
        site.kill(owner);
        let next = site.owner_other_than(&held).await;
        assert_ne!(next.node, owner);
        watcher.more(8).await;
        silences.push(watcher.silence_s(before));
        println!(
            "{owner} killed, {} owns: 8 slots within {:.2} s, silence {:.2} s",
            next.node,
            began.elapsed().as_secs_f64(),
            silences[silences.len() - 1]
        );
        site.run(owner);
    }
    site.pair().await;
    let summary = watcher.checked().await;
    let mean_s = silences.iter().sum::<f64>() / count as f64;
    println!(
        "{count} owners killed, lease {lease_s} s, seed {seed}: silence {mean_s:.2} s in the mean, {:.2} s at most; {summary:?}",
        summary.silence_s
    );
    assert!(summary.epochs.len() > count && summary.numbers.len() >= 3, "{summary:?}");
    assert!(summary.silence_s < lease_s + 1.0 + SLACK_S, "{summary:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn suspended_owner_publishes_nothing_and_becomes_standby() {
    let Some(mut site) = Site::start(Setup::default()).await else { return };
    let watcher = site.watch().await;
    let [owner, standby] = site.pair().await;
    let held = site.owner().await.unwrap();
    let before = watcher.slots();
    site.signal(owner, "-STOP");
    let stood = Instant::now();
    site.owner_other_than(&held).await;
    watcher.more(8).await;
    println!("{owner} stands still: silence {:.2} s", watcher.silence_s(before));
    tokio::time::sleep(Duration::from_secs(10).saturating_sub(stood.elapsed())).await;
    site.signal(owner, "-CONT");
    until("it knows that it was replaced", async || {
        site.report(owner).await.filter(|report| report.cells[0].1.fenced > 0)
    })
    .await;
    // The third node has the standby role meanwhile.
    let third = NODES.into_iter().find(|node| ![owner, standby].contains(node)).unwrap();
    site.kill(third);
    until("it stands by", async || (site.pair().await == [standby, owner]).then_some(())).await;
    watcher.more(8).await;
    let status = until("a picture in time", async || {
        let status = site.command(&["status"]).await;
        status.status.success().then_some(status)
    })
    .await;
    let status = String::from_utf8(status.stdout).unwrap();
    let line = |node: &str| status.lines().find(|line| line.starts_with(node)).unwrap_or_default().to_owned();
    assert!(line(owner).contains("standby") && line(standby).contains("owner"), "{status}");
    let summary = watcher.checked().await;
    println!("{summary:?}");
    assert!(summary.silence_s < LEASE_S + 1.0 + SLACK_S, "{summary:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn drained_owner_loses_no_slot_and_differences_are_found() {
    let Some(site) = Site::start(Setup::default()).await else { return };
    let watcher = site.watch().await;
    let [owner, standby] = site.pair().await;
    let before = watcher.slots();
    let drained = site.command(&["drain", owner]).await;
    assert!(drained.status.success(), "{drained:?}");
    assert_eq!(site.owner().await.unwrap().node, standby);
    watcher.more(8).await;
    println!("{owner} drained: silence {:.2} s", watcher.silence_s(before));
    assert!(watcher.silence_s(before) < 0.5 + SLACK_S);
    let [owner, standby] = site.pair().await;
    let (code, verdict) = verified(&site, "10s").await;
    println!("{verdict}");
    // Except for late slots the result does not depend on the machine's speed.
    let is_late = verdict["late"] != 0;
    assert!(verdict["slots"].as_u64().unwrap() > 20 && verdict["made"].as_u64().unwrap() > 20, "{verdict}");
    assert_eq!((&verdict["doubled"], &verdict["missing"]), (&0.into(), &0.into()), "{verdict}");
    assert_eq!((&verdict["differs"], code), (&false.into(), Some(if is_late { 5 } else { 0 })), "{verdict}");
    watcher.checked().await;

    // The owner is suspended while a foreign output is written that no input has produced.
    let lease = site.owner().await.unwrap();
    site.signal(owner, "-STOP");
    let verifying = verified(&site, "15s");
    let forging = async {
        // Verification starts from a checkpoint, and has to see the foreign output.
        tokio::time::sleep(Duration::from_secs(1)).await;
        let (sequence, last) = site.log.last(WHOLE).await.unwrap().unwrap();
        // Use the picture of the previous slot.
        let forged = CellOutput { slot: last.slot.plus(1), ..last };
        assert!(matches!(site.log.append(WHOLE, sequence, &forged).await, AppendResult::Stored(_)));
        site.signal(owner, "-CONT");
        until("the standby notices, and keeps its state", async || {
            let report = site.report(standby).await?;
            (!report.skipped.is_empty() && report.cells[0].1.diverged == 0).then_some(())
        })
        .await;
    };
    let ((code, verdict), ()) = tokio::join!(verifying, forging);
    println!("{verdict}");
    // The foreign message has no picture of its slot; the owner published that slot under another message name.
    assert!(verdict["skipped"] != 0 && verdict["missing"] == 0 && code == Some(5), "{code:?} {verdict}");
    // Afterwards owner and standby have the same state again.
    let [owner, _] = site.pair().await;
    println!("{lease:?} before, {owner} owns");
    site.watch().await.more(8).await;
    let (code, verdict) = verified(&site, "3s").await;
    println!("{code:?} {verdict}");
    assert_eq!(verdict["differs"], false, "{verdict}");
}

async fn verified(site: &Site, lasts: &str) -> (Option<i32>, Value) {
    let output = site.command(&["verify", "--json", "--duration", lasts]).await;
    let verdicts: Value = serde_json::from_slice(&output.stdout).unwrap();
    (output.status.code(), verdicts["cells"][WHOLE].clone())
}

/// A node with another site configuration would make another picture.
#[tokio::test(flavor = "multi_thread")]
async fn node_with_other_configuration_is_refused_by_difference() {
    let Some(mut site) = Site::start(Setup::default()).await else { return };
    let held = site.owner().await.unwrap();
    let config = std::sync::Arc::make_mut(&mut site.config);
    config.fusion.latency_slots = 24;
    let code = site.node_with("other", site.cluster.clone()).await;
    let said = site.log_text("other");
    assert!(
        code == Some(3) && said.contains("fusion.latency_s is 6.25 there, and 6.0 here"),
        "{code:?} {said}"
    );
    assert_eq!(site.owner().await.unwrap(), held, "nobody has taken over");
}

/// A killed gateway is reported as missing until it comes back or is forgotten.
#[tokio::test(flavor = "multi_thread")]
async fn killed_gateway_is_missing_until_forgotten() {
    let Some(mut site) = Site::start(Setup::default()).await else { return };
    until("all is well", async || site.command(&["status"]).await.status.success().then_some(())).await;
    let began = Instant::now();
    site.kill("g1");
    until("an alert", async || {
        let (_, alerts) = site.ask("/api/v1/alerts").await?;
        alerts.to_string().contains("gateway g1 says nothing").then_some(())
    })
    .await;
    println!("named after {:.1} s", began.elapsed().as_secs_f64());
    let status = site.command(&["status"]).await;
    let said = String::from_utf8_lossy(&status.stderr).into_owned();
    assert!(status.status.code() == Some(1) && said.contains("gateway g1 says nothing"), "{said}");
    assert_eq!(site.command(&["forget", "g0"]).await.status.code(), Some(2), "it runs");
    assert!(site.command(&["forget", "g1"]).await.status.success());
    until("all is well", async || site.command(&["status"]).await.status.success().then_some(())).await;
}
