//! Outages of gateways, of the log's servers, and of the connection to them.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use async_nats::jetstream;
use jiff::SignedDuration;
use serde_json::Value;
use utm_fusion::cluster::{CellOutput, Log, WHOLE};
use utm_fusion::config::Cluster;

use crate::proxy::Proxy;
use crate::servers::Store;
use crate::site::{GATEWAYS, LEASE_S, NODES, PICTURE, SLACK_S, Setup, Site, until, variable};

fn texts(value: &Value) -> Vec<&str> {
    value.as_array().into_iter().flatten().filter_map(Value::as_str).collect()
}

/// Names of all lines of the sensors, as the picture shows them.
async fn lines(site: &Site) -> Option<Vec<String>> {
    let (_, sensors) = site.ask("/api/v1/sensors").await?;
    let of = |sensor: &Value| sensor["properties"]["lines"].as_array().cloned().unwrap_or_default();
    let lines = sensors["features"].as_array()?.iter().flat_map(of);
    Some(lines.filter_map(|line| line["name"].as_str().map(str::to_owned)).collect())
}

#[tokio::test(flavor = "multi_thread")]
async fn one_gateway_suffices_and_none_is_reported() {
    let Some(mut site) = Site::start(Setup::default()).await else { return };
    let watcher = site.watch().await;
    until("lines of both", async || (lines(&site).await?.len() == 4).then_some(())).await;
    until("ready", async || (site.ask("/readyz").await?.0 == 200).then_some(())).await;
    site.kill(GATEWAYS[0]);
    watcher.more(20).await;
    let left = until("lines of one", async || lines(&site).await.filter(|lines| lines.len() == 2)).await;
    assert!(left.iter().all(|line| line.ends_with(" at g1")), "{left:?}");
    let (code, _) = site.ask("/readyz").await.unwrap();
    assert_eq!(code, 200);

    site.kill(GATEWAYS[1]);
    let began = Instant::now();
    let not_ready = until("not ready", async || {
        site.ask("/readyz").await.filter(|(code, _)| *code == 503).map(|(_, body)| body)
    })
    .await;
    println!("without a gateway: not ready after {:.1} s: {not_ready}", began.elapsed().as_secs_f64());
    let (_, status) = site.ask("/api/v1/status").await.unwrap();
    assert!(texts(&status["reasons"]).iter().any(|reason| reason.contains("gateway")), "{status}");
    site.run(GATEWAYS[1]);
    until("ready again", async || (site.ask("/readyz").await?.0 == 200).then_some(())).await;
    let summary = watcher.checked().await;
    println!("{summary:?}");
    assert!(summary.slots > 20 && summary.silence_s < SLACK_S && summary.epochs.len() == 1, "{summary:?}");
}

/// Kills the three servers one by one, first the leader of the outputs.
#[tokio::test(flavor = "multi_thread")]
async fn servers_killed_one_by_one_lose_no_slot() {
    let count = variable("UTM_FUSION_SERVERS_KILLED", 2.0) as usize;
    let setup = Setup { servers: 3, checkpoint_s: 5.0, ..Setup::default() };
    let Some(mut site) = Site::start(setup).await else { return };
    let streams = jetstream::new(site.servers.client().await);
    let watcher = site.watch().await;
    let leader = site.servers.leader(&streams, "UTM_OUT_trial").await.unwrap();
    for index in (0..count).map(|turn| (leader + turn) % 3) {
        site.pair().await;
        watcher.in_time().await;
        let before = watcher.slots();
        site.servers.kill(index);
        watcher.more(20).await;
        println!("server {index} killed: silence {:.2} s", watcher.silence_s(before));
        site.servers.restart(index, Store::Kept);
        site.servers.ready().await;
    }
    let summary = watcher.checked().await;
    println!("{summary:?}");
    assert!(summary.silence_s < 10.0 + SLACK_S, "{summary:?}");
}

/// Slots published from now on.
async fn slots(site: &Site, count: usize) -> BTreeSet<i64> {
    let mut outputs = site.log.outputs(WHOLE, 1);
    let mut slots = BTreeSet::new();
    while slots.len() < count {
        let read = tokio::time::timeout(Duration::from_secs(60), outputs.next()).await.expect("slots come");
        let Some((_, octets)) = read else {
            outputs = site.log.outputs(WHOLE, 1);
            continue;
        };
        let slot = CellOutput::parse(&octets).unwrap().slot.0;
        assert!(slots.insert(slot), "slot {slot} is doubled");
    }
    slots
}

#[tokio::test(flavor = "multi_thread")]
async fn numbers_survive_the_loss_of_all_servers() {
    let servers = variable("UTM_FUSION_SERVERS", 1.0) as usize;
    let setup = Setup { servers, checkpoint_s: 2.0, ..Setup::default() };
    let Some(mut site) = Site::start(setup).await else { return };
    let watcher = site.watch().await;
    watcher.more(48).await;
    let written = until("a checkpoint of the standby", async || {
        let [_, standby] = site.pair().await;
        let counts = site.report(standby).await?.cells[0].1;
        (counts.checkpoints > 1).then_some(())
    });
    written.await;
    let before = watcher.checked().await;
    let last = site.log.last(WHOLE).await.unwrap().unwrap().1.slot.0;
    let seq = site.ask("/api/v1/status").await.unwrap().1["seq"].as_u64().unwrap();
    let began = Instant::now();
    site.servers.kill_all();
    site.servers.start_all(Store::Kept).await;
    println!("servers are back after {:.1} s", began.elapsed().as_secs_f64());
    let after = slots(&site, 8).await;
    println!("slots again after {:.1} s", began.elapsed().as_secs_f64());
    assert!(*after.first().unwrap() > last, "{last} {after:?}");
    site.pair().await;
    until("the picture goes on", async || {
        let (_, status) = site.ask("/api/v1/status").await?;
        (status["seq"].as_u64()? > seq + 8 && status["ready"] == true).then_some(())
    })
    .await;
    assert!(!site.log_text(PICTURE).contains("came twice"), "{}", site.log_text(PICTURE));
    let begun = NODES.iter().filter(|node| site.log_text(node).matches("begins without a state").count() > 0);
    assert!(begun.count() > 0);
    // Numbers of aircraft with a transponder are permanent.
    let watcher = site.watch().await;
    watcher.more(48).await;
    let after = watcher.checked().await;
    println!("{before:?}\n{after:?}");
    let own = |numbers: &[u32]| -> BTreeSet<u32> {
        numbers.iter().filter(|number| **number >= 10_000).map(|number| number / 10_000).collect()
    };
    assert_eq!(own(&before.numbers), own(&after.numbers));
}

/// All servers stop answering for some time, and then continue.
#[tokio::test(flavor = "multi_thread")]
async fn servers_paused_together_lose_no_slot_and_no_number() {
    let servers = variable("UTM_FUSION_SERVERS", 1.0) as usize;
    let halted = Duration::from_secs_f64(variable("UTM_FUSION_HALTED", 10.0));
    let Some(site) = Site::start(Setup { servers, checkpoint_s: 5.0, ..Setup::default() }).await else {
        return;
    };
    let watcher = site.watch().await;
    watcher.in_time().await;
    watcher.more(20).await;
    (0..servers).for_each(|server| site.servers.halt(server));
    tokio::time::sleep(halted).await;
    (0..servers).for_each(|server| site.servers.resume(server));
    watcher.more(40).await;
    watcher.in_time().await;
    let summary = watcher.checked().await;
    let beyond_s = summary.silence_s - halted.as_secs_f64();
    println!("silence beyond the halt {beyond_s:.2} s; {summary:?}");
    assert!(beyond_s < 5.0 + SLACK_S, "{summary:?}");
    let mut ids = BTreeMap::<String, BTreeSet<String>>::new();
    for (id, serial) in summary.aircraft.0.iter().flat_map(|(_, aircraft)| aircraft) {
        ids.entry(serial.clone().unwrap_or_default()).or_default().insert(id.clone());
    }
    ids.remove("");
    assert!(ids.len() >= 3 && ids.values().all(|ids| ids.len() == 1), "{ids:?}");
}

/// Nodes and servers are restarted, the servers without the streams in memory: the checkpoint on disk belongs to other streams.
#[tokio::test(flavor = "multi_thread")]
async fn checkpoint_of_other_streams_is_ignored() {
    let Some(mut site) = Site::start(Setup { checkpoint_s: 2.0, ..Setup::default() }).await else { return };
    site.watch().await.more(20).await;
    NODES.iter().for_each(|node| site.kill(node));
    site.servers.kill_all();
    site.servers.start_all(Store::Kept).await;
    NODES.iter().for_each(|node| site.run(node));
    until("somebody begins without it", async || {
        let said: String = NODES.iter().map(|node| site.log_text(node)).collect();
        // Once at the first start, and once now.
        (said.matches("begins without a state").count() > 1).then_some(())
    })
    .await;
    site.pair().await;
    let watcher = site.watch().await;
    watcher.more(20).await;
    println!("{:?}", watcher.checked().await);
}

/// A member with other settings does not change existing streams.
#[tokio::test(flavor = "multi_thread")]
async fn streams_with_other_settings_are_a_named_error() {
    let Some(mut site) = Site::start(Setup::default()).await else { return };
    for (changed, told) in [
        (
            Cluster { lease_s: 5.0, ..site.cluster.clone() },
            "KV_UTM_OWN_trial is there with max_age = 2s, and 5s is wanted: delete it, or use another region",
        ),
        (
            Cluster { replicas: 3, ..site.cluster.clone() },
            "KV_UTM_OWN_trial is there with replicas = 1, and 3 is wanted: delete it, or use another region",
        ),
    ] {
        let code = site.node_with("other", changed).await;
        let said = site.log_text("other");
        assert!(
            code == Some(1) && said.lines().last().is_some_and(|line| line.contains(told)),
            "{code:?} {said}"
        );
    }
    // A shorter lease is accepted, so that members can be changed one by one.
    Log::open(&Cluster { lease_s: 1.0, ..site.cluster.clone() }).await.unwrap();
    let watcher = site.watch().await;
    watcher.more(8).await;
    println!("{:?}", watcher.checked().await);
}

#[tokio::test(flavor = "multi_thread")]
async fn disconnected_owner_is_replaced_and_becomes_standby() {
    let cut = Duration::from_secs_f64(variable("UTM_FUSION_CUT", 8.0));
    let Some((servers, scratch)) = crate::cluster(1).await else { return };
    let mut proxies = Vec::new();
    for node in NODES {
        proxies.push((node, Proxy::start(servers.address(0)).await));
    }
    let through = proxies.iter().map(|(node, proxy)| (*node, proxy.url())).collect();
    let mut site = Site::over(servers, scratch, Setup { through, ..Setup::default() }).await;
    let watcher = site.watch().await;
    let [owner, standby] = site.pair().await;
    let held = site.owner().await.unwrap();
    let before = watcher.slots();
    let proxy = &proxies.iter().find(|(node, _)| *node == owner).unwrap().1;
    proxy.stall();
    let began = Instant::now();
    let next = site.owner_other_than(&held).await;
    watcher.more(8).await;
    println!("{owner} is cut off: {} owns, silence {:.2} s", next.node, watcher.silence_s(before));
    assert_eq!(next.node, standby);
    tokio::time::sleep(cut.saturating_sub(began.elapsed())).await;
    proxy.resume();
    let third = NODES.into_iter().find(|node| ![owner, standby].contains(node)).unwrap();
    site.kill(third);
    until("it stands by", async || (site.pair().await == [standby, owner]).then_some(())).await;
    watcher.more(8).await;
    let summary = watcher.checked().await;
    println!("{summary:?}");
    assert!(summary.silence_s < LEASE_S + 1.0 + SLACK_S, "{summary:?}");
}

/// One sensor's line is 2 s slower than the other's; then both gateways are suspended for 2 s.
#[tokio::test(flavor = "multi_thread")]
async fn late_feed_makes_no_slot_late() {
    let Some(mut site) = Site::start(Setup::default()).await else { return };
    let watcher = site.watch().await;
    site.fly_late(129, SignedDuration::from_secs(2));
    let looked = Instant::now();
    let mut is_late = false;
    while looked.elapsed() < Duration::from_secs(12) {
        if looked.elapsed() > Duration::from_secs(8) && !is_late {
            GATEWAYS.iter().for_each(|gateway| site.signal(gateway, "-STOP"));
            tokio::time::sleep(Duration::from_secs(2)).await;
            GATEWAYS.iter().for_each(|gateway| site.signal(gateway, "-CONT"));
            is_late = true;
        }
        let (_, status) = site.ask("/api/v1/status").await.unwrap();
        let late_s = status["late_s"].as_f64().unwrap_or_default();
        assert!(late_s <= 1.0 || status["state"] != "ok", "{status}");
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    let summary = watcher.checked().await;
    println!("{summary:?}");
    assert!(summary.latest_s < 0.5 + SLACK_S && summary.epochs.len() == 1, "{summary:?}");
}
