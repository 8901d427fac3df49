//! Foreign messages on every subject and key of the log do not stop a cell.

use std::time::{Duration, Instant};

use async_nats::HeaderMap;
use async_nats::jetstream::{self, kv};
use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE;
use bytes::Bytes;
use fusion::slots::Slot;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use utm_fusion::cluster::{CellOutput, Holder, WHOLE, pictures};

use crate::site::{NODES, SLACK_S, Setup, Site, until, variable};

/// Maximum time without a new slot while other clients write, in seconds. It is less than after the loss of an owner.
const SILENCE_S: f64 = 1.0 + SLACK_S;
/// First octets of truncated, unknown and invalid messages.
const MESSAGE_PREFIXES: [&[u8]; 8] =
    [b"", b"UTM1", b"UTM2", b"UTO2", b"UTO3", b"UTO4", b"UTL1", b"{\"node\":"];

/// New slots of the cell, with the time of arrival.
struct SlotArrivals {
    seen: std::sync::Arc<std::sync::Mutex<Vec<(i64, usize, Instant)>>>,
    task: tokio::task::JoinHandle<()>,
}

impl SlotArrivals {
    async fn watch(site: &Site) -> Self {
        let (log, seen) = (site.log.clone(), std::sync::Arc::<std::sync::Mutex<Vec<_>>>::default());
        let (mut outputs, into) = (log.outputs(WHOLE, 0), seen.clone());
        let task = tokio::spawn(async move {
            while let Some((_, octets)) = outputs.next().await {
                let Some(output) = log.validated_when_available(WHOLE, &octets).await else { continue };
                let tracks = pictures(&output.picture).unwrap().0.tracks.len();
                into.lock().unwrap().push((output.slot.0, tracks, Instant::now()));
            }
        });
        let slots = Self { seen, task };
        until("aircraft", async || {
            slots.seen.lock().unwrap().last().is_some_and(|(_, tracks, _)| *tracks > 0).then_some(())
        })
        .await;
        slots.seen.lock().unwrap().clear();
        slots
    }

    fn count(&self) -> usize {
        self.seen.lock().unwrap().len()
    }

    async fn more(&self, slots: usize) {
        let before = self.count();
        until("more slots", async || (self.count() >= before + slots).then_some(())).await;
    }

    /// Longest time between two new slots, number of missing slots, and number of slots without aircraft.
    fn summary(self) -> (f64, usize, usize) {
        self.task.abort();
        let seen = self.seen.lock().unwrap();
        let mut new: Vec<(i64, Instant)> = Vec::new();
        for (slot, _, at) in seen.iter() {
            // A slot far from the others is a foreign one.
            if new.last().is_none_or(|(last, _)| *slot > *last && *slot < last + 100) {
                new.push((*slot, *at));
            }
        }
        let silence = new.windows(2).map(|pair| (pair[1].1 - pair[0].1).as_secs_f64()).fold(0.0, f64::max);
        let missing: i64 = new.windows(2).map(|pair| pair[1].0 - pair[0].0 - 1).sum();
        let full = |slot: i64| seen.iter().any(|(of, tracks, _)| *of == slot && *tracks > 0);
        let empty = new.iter().filter(|(slot, _)| !full(*slot)).count();
        (silence, missing as usize, empty)
    }
}

/// Writes like any client that reaches the servers.
struct Attacker {
    streams: jetstream::Context,
    random: ChaCha8Rng,
}

impl Attacker {
    async fn of(site: &Site, seed: u64) -> Self {
        let streams = jetstream::new(site.servers.client().await);
        Self { streams, random: ChaCha8Rng::seed_from_u64(seed) }
    }

    async fn write(&self, subject: &str, octets: impl Into<Bytes>) {
        // If the server refuses, nothing was written.
        if let Ok(sent) = self.streams.publish(subject.to_owned(), octets.into()).await {
            drop(sent.await);
        }
    }

    async fn write_as(&self, subject: &str, header: (&str, &str), octets: impl Into<Bytes>) {
        let mut headers = HeaderMap::new();
        headers.insert(header.0, header.1);
        if let Ok(sent) = self.streams.publish_with_headers(subject.to_owned(), headers, octets.into()).await
        {
            drop(sent.await);
        }
    }

    fn random_octets(&mut self) -> Vec<u8> {
        let mut octets = MESSAGE_PREFIXES[self.random.random_range(0..MESSAGE_PREFIXES.len())].to_vec();
        let length = self.random.random_range(0..200);
        octets.extend((0..length).map(|_| self.random.random::<u8>()));
        octets
    }
}

fn key(name: &str) -> String {
    format!("$KV.UTM_OWN_trial.{name}")
}

/// All subjects and keys of a region.
fn all_subjects() -> Vec<String> {
    let mut all_subjects: Vec<String> = [
        "utm.out.trial.all",
        "utm.out.trial.nowhere",
        "utm.in.trial.25.1",
        "utm.in.trial.to.all",
        "utm.in.trial.x",
    ]
    .map(str::to_owned)
    .to_vec();
    let keys =
        ["all.owner", "all.standby", "all.wanted", "all.report", "node.n0", "node.n1", "node.n2", "node.x"];
    all_subjects.extend(keys.map(key));
    all_subjects.extend(["gateway.g0", "gateway.g1", "gateway.x", "drain.n0", "drain.n1", "else"].map(key));
    all_subjects.extend(
        ["b.0", "b.99999999999", "s.00", "gateway.g0", "config.0"]
            .map(|of| format!("$KV.UTM_NUM_trial.{of}")),
    );
    all_subjects.push(format!("$O.UTM_CK_trial.M.{}", URL_SAFE.encode("all")));
    all_subjects.push("$O.UTM_CK_trial.C.nobody".to_owned());
    all_subjects
}

fn report_and_check(slots: SlotArrivals, what: &str) {
    let (silence_s, missing, empty) = slots.summary();
    println!("{what}: longest silence {silence_s:.2} s, {missing} slots missing, {empty} without aircraft");
    assert!(silence_s <= SILENCE_S, "{what}: {silence_s} s");
    assert_eq!((missing, empty), (0, 0), "{what}");
}

#[tokio::test(flavor = "multi_thread")]
async fn single_foreign_message_stops_no_owner() {
    let Some(site) = Site::start(Setup::default()).await else { return };
    let (slots, attacker) = (SlotArrivals::watch(&site).await, Attacker::of(&site, 1).await);
    let held = site.owner().await.unwrap();
    for octets in [&b"hello"[..], b"UTO4 of tomorrow", b"", b"UTO2 cut"] {
        attacker.write("utm.out.trial.all", octets).await;
        slots.more(4).await;
    }
    assert_eq!(site.owner().await.unwrap(), held);
    let status = site.command(&["status"]).await;
    let said = String::from_utf8_lossy(&status.stderr).into_owned();
    assert!(status.status.code() == Some(1) && said.contains("a message of version UTO4"), "{said}");
    report_and_check(slots, "four messages that are no outputs");
}

/// Writes `UTM_FUSION_ODD` random messages to each subject and key.
#[tokio::test(flavor = "multi_thread")]
async fn random_messages_on_every_subject_stop_no_cell() {
    let Some(site) =
        Site::start(Setup { servers: variable("UTM_FUSION_SERVERS", 1.0) as usize, ..Setup::default() })
            .await
    else {
        return;
    };
    let count = variable("UTM_FUSION_ODD", 300.0) as usize;
    let slots = SlotArrivals::watch(&site).await;
    let mut attacker = Attacker::of(&site, variable("UTM_FUSION_SEED", 1.0) as u64).await;
    let (all_subjects, began) = (all_subjects(), Instant::now());
    for _ in 0..count {
        for place in &all_subjects {
            let octets = attacker.random_octets();
            attacker.write(place, octets).await;
        }
        tokio::time::sleep(Duration::from_millis(30)).await;
    }
    println!("{} messages within {:.1} s", count * all_subjects.len(), began.elapsed().as_secs_f64());
    slots.more(16).await;
    site.pair().await;
    report_and_check(slots, "random messages at every place");
}

/// Writes outputs that look like an owner's.
#[tokio::test(flavor = "multi_thread")]
async fn forged_outputs_stop_no_cell() {
    let Some(site) = Site::start(Setup::default()).await else { return };
    let (slots, attacker) = (SlotArrivals::watch(&site).await, Attacker::of(&site, 1).await);
    let (_, first) = site.log.last(WHOLE).await.unwrap().unwrap();
    let held = site.owner().await.unwrap();
    type Change = fn(CellOutput) -> CellOutput;
    let invented: Vec<(&str, Change)> = vec![
        ("lease of 2^63", |last| CellOutput { epoch: 1 << 63, slot: last.slot.plus(1), ..last }),
        ("next lease", |last| CellOutput { epoch: last.epoch + 1, slot: last.slot.plus(1), ..last }),
        ("own lease, no picture", |last| CellOutput { slot: last.slot.plus(1), picture: Vec::new(), ..last }),
        ("own lease, the last picture", |last| CellOutput { slot: last.slot.plus(1), ..last }),
        ("lease of before", |last| CellOutput { epoch: 1, slot: last.slot.plus(1), ..last }),
        ("no lease", |last| CellOutput { epoch: 0, slot: last.slot.plus(1), ..last }),
        ("slot of an hour ahead", |last| CellOutput { slot: last.slot.plus(14_400), ..last }),
        ("last slot that there is", |last| CellOutput { slot: Slot(i64::MAX), ..last }),
        ("first slot that there is", |last| CellOutput { slot: Slot(i64::MIN), ..last }),
        ("an input to come", |last| CellOutput { after_input: u64::MAX, slot: last.slot.plus(1), ..last }),
        ("no input", |last| CellOutput { after_input: 0, slot: last.slot.plus(1), ..last }),
        ("picture of nonsense", |last| CellOutput {
            picture: vec![255; 64],
            slot: last.slot.plus(1),
            ..last
        }),
    ];
    for (what, invent) in invented {
        let before = slots.count();
        for _ in 0..4 {
            let (_, last) = site.log.last(WHOLE).await.unwrap().unwrap();
            attacker.write("utm.out.trial.all", invent(last).body()).await;
            tokio::time::sleep(Duration::from_millis(120)).await;
        }
        attacker.write("utm.out.trial.all", first.body()).await;
        slots.more(2).await;
        println!("{what}: {} slots", slots.count() - before);
        assert_eq!(site.owner().await.as_ref(), Some(&held), "{what}");
    }
    // Take the message names of the slots of the next 30 s.
    let (_, last) = site.log.last(WHOLE).await.unwrap().unwrap();
    for ahead in 1..120 {
        let name = format!("all:{}", last.slot.0 + ahead);
        attacker.write_as("utm.out.trial.all", ("Nats-Msg-Id", &name), "claimed").await;
    }
    slots.more(20).await;
    assert_eq!(site.owner().await.unwrap(), held);
    report_and_check(slots, "invented outputs");
}

/// Overwrites the lease, the standby role and the reports each second.
#[tokio::test(flavor = "multi_thread")]
async fn overwritten_keys_stop_no_cell() {
    let Some(site) = Site::start(Setup::default()).await else { return };
    let (slots, attacker) = (SlotArrivals::watch(&site).await, Attacker::of(&site, 1).await);
    let [owner, standby] = site.pair().await;
    let name = |holder: &Holder| serde_json::to_vec(holder).unwrap();
    let unknown_node = Holder { node: "nobody".to_owned(), machine: "nowhere".to_owned(), run: 7, config: 0 };
    let of = |node| site.report(node);
    let (own, beside) = (of(owner).await.unwrap().holder, of(standby).await.unwrap().holder);
    let third = NODES.into_iter().find(|node| ![owner, standby].contains(node)).unwrap();
    let third = of(third).await.unwrap().holder;
    let report = site.log.entry("all.report").await.unwrap().unwrap();
    for (what, octets) in [
        ("octets", b"hello".to_vec()),
        ("nothing", Vec::new()),
        ("a stranger", name(&unknown_node)),
        ("the owner", name(&own)),
        ("who stands by", name(&beside)),
        ("the third one", name(&third)),
    ] {
        let began = Instant::now();
        while began.elapsed() < Duration::from_secs(4) {
            for place in ["all.owner", "all.standby", "all.wanted", "drain.n0", "drain.n1", "drain.n2"] {
                attacker.write(&key(place), octets.clone()).await;
            }
            attacker.write(&key("all.report"), report.clone()).await;
            tokio::time::sleep(Duration::from_secs(1)).await;
        }
        slots.more(2).await;
        println!("{what}: {:?} owns", site.owner().await.map(|by| by.node));
    }
    // Delete the lease, then all keys at once.
    attacker.write_as(&key("all.owner"), ("KV-Operation", "DEL"), "").await;
    slots.more(16).await;
    attacker.write_as(&key("all.owner"), ("Nats-Rollup", "all"), "hello").await;
    slots.more(16).await;
    site.pair().await;
    let store: kv::Store = attacker.streams.get_key_value("UTM_OWN_trial").await.unwrap();
    assert!(store.entry("all.owner").await.unwrap().is_some());
    report_and_check(slots, "keys written over");
}
