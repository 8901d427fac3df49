//! A node has a third of the processor time that it needs, which corresponds to three times its maximum load. Other processes on
//! the machine are not loaded.

use std::collections::BTreeSet;
use std::time::Duration;

use crate::site::{Setup, Site, until};

/// Approximate interval at which it continues, in seconds.
const RESUME_INTERVAL_S: f64 = 1.0;
/// All levels. At the last one a node leaves a cell to another node if it owns several, which it does not here.
const LEVELS: [u8; 7] = [0, 1, 3, 4, 5, 6, 7];

#[tokio::test(flavor = "multi_thread")]
async fn overload_is_shed_in_order_without_transponders() {
    let Some(site) = Site::start(Setup { is_crowded: true, ..Setup::default() }).await else { return };
    let watcher = site.watch().await;
    watcher.in_time().await;
    let [owner, _] = site.pair().await;
    let held = site.owner().await.unwrap();
    let needs =
        site.share(owner, Duration::from_secs(5), async |lasts| tokio::time::sleep(lasts).await).await;
    let starved = async |lasts: Duration| site.starve(owner, needs / 3.0, lasts, RESUME_INTERVAL_S).await;
    let gets = site.share(owner, Duration::from_secs(25), starved).await;
    println!("{owner} needs {:.1} % of a core, and got {:.1} %", 100.0 * needs, 100.0 * gets);
    assert!(gets < 0.7 * needs, "it was not overloaded: {gets} of {needs}");
    let step = until("the picture says what is left out", async || {
        let (_, cluster) = site.ask("/api/v1/cluster").await?;
        cluster["cells"][0]["step"].as_u64().filter(|step| *step > 0)
    })
    .await;
    watcher.in_time().await;
    println!("in time again; step {step}");
    assert_eq!(site.owner().await.unwrap(), held, "it lost the cell");
    // This also checks that each slot equals what an engine at the same level makes.
    let summary = watcher.checked().await;
    println!("{summary:?}");
    let taken = summary.levels.iter().zip(LEVELS).take_while(|(step, expected)| **step == *expected).count();
    assert!(taken > 3 && taken == summary.levels.len(), "steps {:?} of {LEVELS:?}", summary.levels);
    let equipped = |slot: &(i64, Vec<crate::watcher::AircraftName>)| -> BTreeSet<String> {
        slot.1.iter().filter_map(|(_, serial)| serial.clone()).collect()
    };
    // Each transponder counts from its first slot on; a transponder is silent at times by itself.
    let (mut all, mut missing, mut of) = (BTreeSet::new(), 0, 0);
    for slot in &summary.aircraft.0 {
        let shown = equipped(slot);
        (missing, of) = (missing + all.difference(&shown).count(), of + all.len());
        all.extend(shown);
    }
    println!("{} transponders, in {missing} of {of} slots missing", all.len());
    assert!(all.len() > 54 && missing * 200 < of, "{missing} of {of} are missing, of {}", all.len());
}
