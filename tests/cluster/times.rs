//! Clocks that are seconds or minutes wrong (libfaketime), of one of two gateways or one of three nodes: no single clock decides.

use std::time::{Duration, Instant};

use jiff::SignedDuration;
use serde_json::Value;

use utm_fusion::cluster::{CellOutput, WHOLE, pictures};

use crate::clocks::faketime;
use crate::site::{GATEWAYS, LEASE_S, NODES, SLACK_S, Setup, Site, until};
use crate::watcher::{Summary, Watcher};

/// Clock errors in seconds: the comma-separated values of `UTM_FUSION_WRONG_S`, or the default.
fn errors_s(otherwise: &[i64]) -> Vec<i64> {
    match std::env::var("UTM_FUSION_WRONG_S") {
        Ok(text) => text.split(',').map(|error_s| error_s.parse().unwrap()).collect(),
        Err(_) => otherwise.to_vec(),
    }
}

/// Text of the alert about a member's clock.
async fn clock_alert(site: &Site, member: &str) -> Option<String> {
    let (_, alerts) = site.ask("/api/v1/alerts").await?;
    let is_of = |alert: &&Value| {
        alert["part"] == format!("cluster reference clock {member}").as_str() && alert.get("until").is_none()
    };
    let alerts = alerts["alerts"].as_array()?.iter().find(is_of)?;
    Some(alerts["text"].as_str()?.to_owned())
}

/// Sets a member's clock, waits for the alert and for the end of `meanwhile`, and sets the clock right again.
async fn set(site: &Site, member: &str, error_s: i64, meanwhile: impl AsyncFnOnce()) {
    site.shift(member, SignedDuration::from_secs(error_s));
    let began = Instant::now();
    let text = until("an alert", async || clock_alert(site, member).await).await;
    println!("{member} by {error_s:+} s: named after {:.1} s: {text}", began.elapsed().as_secs_f64());
    // Up to 1 s passes until libfaketime reads its file again.
    assert!(began.elapsed().as_secs_f64() < 10.0 + SLACK_S, "{text}");
    let words = format!(" {member} is ");
    assert!(text.contains(&words) && text.contains(if error_s > 0 { "ahead" } else { "behind" }), "{text}");
    let status = site.command(&["status", "--json"]).await;
    assert_eq!(status.status.code(), Some(1));
    let json: Value = serde_json::from_slice(&status.stdout).unwrap();
    assert!(json["wrong"].to_string().contains(&format!("{member} is ")), "{json}");
    meanwhile().await;
    site.shift(member, SignedDuration::ZERO);
    let began = Instant::now();
    until("no alert", async || clock_alert(site, member).await.is_none().then_some(())).await;
    println!("  right again, and so said after {:.1} s", began.elapsed().as_secs_f64());
}

/// Watches the cell once its aircraft are shown and its slots are in time.
async fn watched(site: &Site) -> Watcher {
    until("aircraft", async || {
        let (_, tracks) = site.ask("/api/v1/tracks").await?;
        (tracks["features"].as_array()?.len() >= 3).then_some(())
    })
    .await;
    let watcher = site.watch().await;
    watcher.in_time().await;
    watcher
}

/// Checks that no slot from `from` on was early or empty. Missing and duplicate slots are checked elsewhere.
fn assert_complete(summary: &Summary, from: usize) {
    let count = |slot: &(i64, Vec<crate::watcher::AircraftName>)| slot.1.len();
    let fewest = summary.aircraft.0[from..].iter().map(count).min().unwrap();
    println!("fewest aircraft in a slot {fewest}; {summary:?}");
    assert!(fewest >= 3, "{summary:?}");
    assert!(summary.early_s < 1.0, "{summary:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn gateway_with_wrong_clock_is_refused_and_named() {
    let Some(library) = faketime() else { return };
    let wrong = GATEWAYS[1];
    let setup = Setup { shifted: Some((wrong, library)), checkpoint_s: 5.0, ..Setup::default() };
    let Some(site) = Site::start(setup).await else { return };
    let watcher = watched(&site).await;
    let before = watcher.slots();
    for error_s in errors_s(&[10, -3]) {
        let began = watcher.slots();
        set(&site, wrong, error_s, async || watcher.more(12).await).await;
        watcher.more(8).await;
        println!("  silence of slots meanwhile {:.2} s", watcher.silence_s(began));
    }
    let refused = async |node| Some(site.report(node).await?.cells[0].1.refused);
    let [owner, _] = site.pair().await;
    assert!(until("its word", async || refused(owner).await).await > 0, "nothing was refused");
    assert!(watcher.silence_s(before) < 1.0 + SLACK_S);
    assert_complete(&watcher.checked().await, before);
    picture_goes_on_behind_a_slot_to_come(&site).await;
}

/// A valid output of a slot one hour ahead, which no owner has written.
async fn picture_goes_on_behind_a_slot_to_come(site: &Site) {
    let (_, last) = until("an output", async || site.log.last(WHOLE).await.ok().flatten()).await;
    let (mut picture, now) = pictures(&last.picture).unwrap();
    picture.slot = picture.slot.plus(14_400);
    let forged =
        CellOutput { slot: picture.slot, picture: postcard::to_stdvec(&(&picture, &now)).unwrap(), ..last };
    let streams = async_nats::jetstream::new(site.servers.client().await);
    let sent = streams.publish(format!("utm.out.trial.{WHOLE}"), forged.body().into()).await.unwrap();
    sent.await.unwrap();
    let shown = async || site.ask("/api/v1/cluster").await?.1["shown"].as_u64();
    let before = until("what is shown", shown).await;
    until("more slots that are shown", async || (shown().await? > before + 8).then_some(())).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn node_with_wrong_clock_hands_over_its_cell() {
    let Some(library) = faketime() else { return };
    let wrong = NODES[0];
    let setup = Setup { shifted: Some((wrong, library)), checkpoint_s: 5.0, ..Setup::default() };
    let Some(mut site) = Site::start(setup).await else { return };
    let watcher = watched(&site).await;
    let before = watcher.slots();
    for error_s in errors_s(&[30]) {
        // The node with the wrong clock has to own the cell first.
        loop {
            let [owner, _] = site.pair().await;
            if owner == wrong {
                break;
            }
            let third = NODES.into_iter().find(|node| ![owner, wrong].contains(node)).unwrap();
            site.kill(third);
            until("it stands by", async || (site.pair().await == [owner, wrong]).then_some(())).await;
            let held = site.owner().await.unwrap();
            site.kill(owner);
            assert_eq!(site.owner_other_than(&held).await.node, wrong);
            [owner, third].into_iter().for_each(|node| site.run(node));
        }
        let (held, began) = (site.owner().await.unwrap(), watcher.slots());
        set(&site, wrong, error_s, async || {
            let next = site.owner_other_than(&held).await;
            println!("  {} owns the cell", next.node);
            watcher.more(12).await;
        })
        .await;
        println!("  silence of slots meanwhile {:.2} s", watcher.silence_s(began));
        assert!(watcher.silence_s(began) < LEASE_S + 1.0 + SLACK_S);
    }
    tokio::time::sleep(Duration::from_secs(1)).await;
    assert_complete(&watcher.checked().await, before);
}
