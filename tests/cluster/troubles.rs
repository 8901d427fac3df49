//! Servers killed, halted and cut off, and how long the log does not take anything.

use std::time::{Duration, Instant};

use async_nats::jetstream;
use async_nats::jetstream::stream::{Config, StorageType};

use crate::proxy::Proxy;
use crate::servers::{self, Store};
use crate::{append, cluster, in_memory};

const MSG_ID: &str = "Nats-Msg-Id";

/// Appends until it is stored; each try is the same message.
async fn stored_within(
    streams: &jetstream::Context,
    subject: &str,
    number: &str,
    limit: Duration,
) -> Duration {
    let began = Instant::now();
    loop {
        match append(streams, subject, (MSG_ID, number)).await {
            Ok(_) => return began.elapsed(),
            Err(error) => assert!(began.elapsed() < limit, "not stored within {limit:?}: {error}"),
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

async fn messages(streams: &jetstream::Context, stream: &str) -> u64 {
    streams.get_stream(stream).await.unwrap().cached_info().state.messages
}

#[tokio::test(flavor = "multi_thread")]
async fn appends_go_on_after_the_leader_was_killed_and_nothing_acknowledged_is_lost() {
    let Some((mut servers, _scratch)) = cluster(3).await else { return };
    let mut streams = jetstream::new(servers.client().await);
    streams.create_stream(in_memory("OUT", "out")).await.unwrap();
    streams.set_timeout(Duration::from_millis(500));
    for number in 0..100 {
        append(&streams, "out.a", (MSG_ID, &number.to_string())).await.unwrap();
    }
    let leader = servers.leader(&streams, "OUT").await.unwrap();
    servers.kill(leader);
    let silence = stored_within(&streams, "out.a", "after", Duration::from_secs(20)).await;
    println!("appends again {silence:?} after the leader was killed");
    assert_eq!(messages(&streams, "OUT").await, 101);

    servers.restart(leader, Store::Empty);
    servers.ready().await;
    // Three again, or the next would have no majority.
    let leader = servers.leader(&streams, "OUT").await.unwrap();
    servers.end(leader);
    let silence = stored_within(&streams, "out.a", "after that", Duration::from_secs(20)).await;
    println!("appends again {silence:?} after the leader was shut down");
    assert_eq!(messages(&streams, "OUT").await, 102);
}

#[tokio::test(flavor = "multi_thread")]
async fn all_killed_and_started_anew_know_what_is_on_disk_and_nothing_else() {
    let Some((mut servers, _scratch)) = cluster(3).await else { return };
    let on_disk = Config { storage: StorageType::File, max_age: Duration::ZERO, ..in_memory("NUM", "num") };
    let streams = jetstream::new(servers.client().await);
    streams.create_stream(in_memory("OUT", "out")).await.unwrap();
    streams.create_stream(on_disk).await.unwrap();
    for subject in ["out.a", "num.a"] {
        append(&streams, subject, (MSG_ID, "1")).await.unwrap();
    }

    // Streams in memory are made again by their names, and are empty.
    servers.kill_all();
    servers.start_all(Store::Kept).await;
    assert_eq!((messages(&streams, "OUT").await, messages(&streams, "NUM").await), (0, 1));

    servers.kill_all();
    servers.start_all(Store::Empty).await;
    for stream in ["OUT", "NUM"] {
        assert!(streams.get_stream(stream).await.is_err(), "{stream} is still there");
    }
    streams.create_stream(in_memory("OUT", "out")).await.unwrap();
    assert_eq!(append(&streams, "out.a", (MSG_ID, "1")).await.unwrap().sequence, 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_halted_server_and_a_cut_line_are_waited_out() {
    let Some((servers, _scratch)) = cluster(1).await else { return };
    let proxy = Proxy::start(servers.address(0)).await;
    let mut streams = jetstream::new(servers::options().connect(proxy.url()).await.unwrap());
    let alone = Config { num_replicas: 1, ..in_memory("OUT", "out") };
    streams.create_stream(alone).await.unwrap();
    streams.set_timeout(Duration::from_millis(300));
    append(&streams, "out.a", (MSG_ID, "before")).await.unwrap();

    proxy.stall();
    append(&streams, "out.a", (MSG_ID, "cut off")).await.unwrap_err();
    proxy.go_on();
    stored_within(&streams, "out.a", "cut off", Duration::from_secs(10)).await;

    servers.halt(0);
    append(&streams, "out.a", (MSG_ID, "halted")).await.unwrap_err();
    servers.go_on(0);
    stored_within(&streams, "out.a", "halted", Duration::from_secs(10)).await;
    // Each was sent twice or more, and is there once.
    assert_eq!(messages(&streams, "OUT").await, 3);
}
