//! Conflicts, as API clients see them.

use serde_json::{Value, json};
use utm_fusion::config::PictureKind;

use crate::common::{Reader, Site, estimated};

/// Most severe first.
const LEVELS: [&str; 4] = ["violation", "warning", "advisory", "none"];

fn rank(conflict: &Value) -> usize {
    LEVELS.iter().position(|level| conflict["level"] == *level).unwrap()
}

fn listed(answer: &Value) -> &Vec<Value> {
    answer["conflicts"].as_array().unwrap()
}

fn time(answer: &Value) -> jiff::Timestamp {
    answer["time"].as_str().unwrap().parse().unwrap()
}

/// Ten drones cross at one point, so there is always a conflict.
#[tokio::test]
async fn conflicts_are_listed_by_severity_with_their_basis() {
    let mut site = Site::foreseeing(PictureKind::Now);
    let mut worst = LEVELS.len();
    for _ in 0..20 {
        site.publish(4).await;
        let answer = site.get("/api/v1/conflicts").await.json();
        assert_eq!((&answer["computed"], answer.get("reason")), (&true.into(), None), "{answer}");
        assert!(answer["aircraft"].as_u64().unwrap() >= 4 && answer["left_out"] == 0, "{answer}");
        let now = site.get("/api/v1/tracks?at=now&max_accuracy_m=10000").await.json();
        let tracks: Vec<&Value> =
            now["features"].as_array().unwrap().iter().map(|track| &track["id"]).collect();
        let ranks: Vec<usize> = listed(&answer).iter().map(rank).collect();
        assert!(ranks.is_sorted(), "{ranks:?}");
        worst = worst.min(ranks.first().copied().unwrap_or(LEVELS.len()));
        for conflict in listed(&answer) {
            assert!(tracks.contains(&&conflict["a"]) && tracks.contains(&&conflict["b"]), "{conflict}");
            assert_eq!(conflict.get("id").is_some(), conflict["level"] != "none", "{conflict}");
            assert_eq!((&conflict["volume"], &conflict["time"]), (&json!("drone"), &answer["time"]));
            let age_s = (time(&now) - time(&answer)).total(jiff::Unit::Second).unwrap();
            assert!((0.0..1.0).contains(&age_s), "of the last full second: {age_s} s");
            let [across, away] = ["miss", "d_cpa_h_m"].map(|name| &conflict[name]);
            assert!(across["across_m"].as_f64().unwrap() <= away.as_f64().unwrap() + 0.011, "{conflict}");
            assert_eq!(conflict["cpa"]["a"].as_array().unwrap().len(), 3);
        }
        let [some, one] =
            ["?level=warning", "?level=advisory"].map(|query| format!("/api/v1/conflicts{query}"));
        let [some, one] = [site.get(&some).await.json(), site.get(&one).await.json()];
        assert_eq!(listed(&some).len(), ranks.iter().filter(|&&rank| rank <= 1).count());
        assert_eq!(listed(&one).len(), ranks.iter().filter(|&&rank| rank <= 2).count());
        if let Some(first) = listed(&answer).first() {
            let of_it =
                site.get(&format!("/api/v1/conflicts?id={}", first["b"].as_str().unwrap())).await.json();
            let is_part = |conflict: &&Value| [&conflict["a"], &conflict["b"]].contains(&&first["b"]);
            assert_eq!(listed(&of_it).len(), listed(&answer).iter().filter(is_part).count());
        }
    }
    assert!(worst <= 1, "nobody was warned of");
    let refused = site.get("/api/v1/conflicts?level=red").await;
    assert_eq!(refused.status, 400);
    assert!(refused.text.contains("violation"), "{}", refused.text);
}

/// An empty list could be taken for a sky without conflicts.
#[tokio::test]
async fn conflicts_not_computed_are_reported_as_such() {
    let reference = Site::plain();
    let off = Site::operational();
    let first = Site::foreseeing(PictureKind::Now);
    for (site, reason) in [(reference, "reference profile"), (off, "switched off"), (first, "yet")] {
        let answer = site.get("/api/v1/conflicts").await.json();
        assert_eq!((&answer["computed"], &answer["conflicts"]), (&false.into(), &json!([])));
        assert!(answer["reason"].as_str().unwrap().contains(reason), "{answer}");
    }
}

#[tokio::test]
async fn outdated_conflicts_are_not_returned() {
    let mut site = Site::foreseeing(PictureKind::Now);
    site.publish(4).await;
    assert_eq!(site.get("/api/v1/conflicts").await.json()["computed"], true);
    let latest = estimated().frames.last().unwrap().clone();
    let seq = latest.seq;
    site.writer.publish(latest);
    site.shown(seq).await;
    let answer = site.get("/api/v1/conflicts").await.json();
    assert_eq!(answer["computed"], false);
    assert!(answer["reason"].as_str().unwrap().contains("late"), "{answer}");
}

#[tokio::test]
async fn conflict_changes_are_streamed_and_raise_alerts() {
    let mut site = Site::foreseeing(PictureKind::Now);
    site.publish(1).await;
    let address = site.listen().await;
    let mut reader = Reader::open(address, "/api/v1/stream", "").await;
    for _ in 0..25 {
        site.publish(4).await;
    }
    let (mut alerts, mut levels) = (Vec::new(), std::collections::BTreeMap::<String, Vec<Value>>::new());
    let last = site.get("/api/v1/tracks").await.json()["seq"].as_u64();
    while let Some(event) = reader.next().await {
        match event.name.as_str() {
            "conflict" => {
                levels.entry(event.data["id"].as_str().unwrap().to_owned()).or_default().push(event.data);
            }
            "alert" if event.data["kind"] == "conflict" => alerts.push(event.data),
            "tracks" if event.data["seq"].as_u64() >= last => break,
            _ => {}
        }
    }
    assert!(levels.len() > 1, "{levels:?}");
    for told in levels.values() {
        // Advisories are published when they begin; more severe levels every second until they end.
        let quiet = |two: &[Value]| two[0]["level"] == two[1]["level"] && rank(&two[0]) >= 2;
        assert!(!told.windows(2).any(quiet), "{told:?}");
        assert_eq!(told[0]["volume"], "drone");
    }
    let warned = levels.values().filter(|told| told.iter().any(|one| rank(one) <= 1)).count();
    let mut raised: Vec<&Value> = alerts.iter().map(|alert| &alert["conflict"]).collect();
    raised.sort_by_key(|id| id.as_str().unwrap().to_owned());
    raised.dedup();
    assert!(warned > 0 && raised.len().abs_diff(warned) <= 1, "{warned} were warned of, {raised:?} raised");
    let alert = &alerts[0];
    assert_eq!(alert["tracks"].as_array().unwrap().len(), 2, "{alert}");
    assert!(alert["text"].as_str().unwrap().contains("drone"), "{alert}");
}

/// On the lagged picture, conflicts are extrapolated to the present.
#[tokio::test]
async fn conflicts_with_the_lagged_picture_are_of_now() {
    let mut site = Site::foreseeing(PictureKind::Lagged);
    site.publish(8).await;
    let answer = site.get("/api/v1/conflicts").await.json();
    assert_eq!(answer["computed"], true, "{answer}");
    let now: jiff::Timestamp =
        site.get("/api/v1/tracks?at=now").await.json()["time"].as_str().unwrap().parse().unwrap();
    let time: jiff::Timestamp = answer["time"].as_str().unwrap().parse().unwrap();
    assert!((now - time).total(jiff::Unit::Second).unwrap().abs() < 1.0, "{time} and {now}");
    assert!(!listed(&answer).is_empty());
}
