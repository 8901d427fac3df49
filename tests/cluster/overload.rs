//! A node is given a third of the processor time that it needs, which is three times the load that it can do, without a load on
//! whatever else runs here.

use std::collections::BTreeSet;
use std::time::Duration;

use crate::site::{Setup, Site, until};

/// It goes on about as often.
const TURN_S: f64 = 1.0;
/// Every step. By the last a node leaves a cell to another one, if it owns several, which it does not here.
const STEPS: [u8; 7] = [0, 1, 3, 4, 5, 6, 7];

#[tokio::test(flavor = "multi_thread")]
async fn three_times_the_load_is_shed_in_order_and_transponders_never() {
    let Some(site) = Site::start(Setup { is_crowded: true, ..Setup::default() }).await else { return };
    let watcher = site.watch().await;
    watcher.in_time().await;
    let [owner, _] = site.pair().await;
    let held = site.owner().await.unwrap();
    let needs =
        site.share(owner, Duration::from_secs(5), async |lasts| tokio::time::sleep(lasts).await).await;
    let starved = async |lasts: Duration| site.starve(owner, needs / 3.0, lasts, TURN_S).await;
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
    // That each slot is what an engine makes which leaves out the same is part of this.
    let summary = watcher.checked().await;
    println!("{summary:?}");
    let taken = summary.steps.iter().zip(STEPS).take_while(|(step, expected)| **step == *expected).count();
    assert!(taken > 3 && taken == summary.steps.len(), "steps {:?} of {STEPS:?}", summary.steps);
    let equipped = |slot: &(i64, Vec<crate::watcher::Called>)| -> BTreeSet<String> {
        slot.1.iter().filter_map(|(_, serial)| serial.clone()).collect()
    };
    // From their first slot on; a transponder is silent at times by itself.
    let (mut all, mut missing, mut of) = (BTreeSet::new(), 0, 0);
    for slot in &summary.aircraft.0 {
        let shown = equipped(slot);
        (missing, of) = (missing + all.difference(&shown).count(), of + all.len());
        all.extend(shown);
    }
    println!("{} transponders, in {missing} of {of} slots missing", all.len());
    assert!(all.len() > 54 && missing * 200 < of, "{missing} of {of} are missing, of {}", all.len());
}
