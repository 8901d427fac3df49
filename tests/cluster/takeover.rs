//! The owner of a cell is lost, in any way: somebody else goes on, and nobody notices but for a short silence.

use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::site::{SLACK_S, Setup, Site, variable};

/// `UTM_FUSION_TAKEOVERS` of them, with leases of `UTM_FUSION_LEASE` seconds.
#[tokio::test(flavor = "multi_thread")]
async fn an_owner_killed_at_any_moment_is_followed() {
    let count = variable("UTM_FUSION_TAKEOVERS", 3.0) as usize;
    let lease_s = variable("UTM_FUSION_LEASE", 3.0);
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
            "{owner} killed, {} owns after {:.2} s, silence {:.2} s",
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
