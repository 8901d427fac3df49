//! Servers killed, suspended and cut off: time for which the log stores nothing.

use std::time::{Duration, Instant};

use async_nats::jetstream;
use async_nats::jetstream::stream::{Config, StorageType};

use crate::proxy::Proxy;
use crate::servers::{self, Store};
use crate::{append, cluster, in_memory};

const MSG_ID: &str = "Nats-Msg-Id";

/// Repeats the same message until it is stored.
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
async fn killed_leader_loses_no_acknowledged_append() {
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
    // All three servers are needed, or the next loss would leave no majority.
    let leader = servers.leader(&streams, "OUT").await.unwrap();
    servers.end(leader);
    let silence = stored_within(&streams, "out.a", "after that", Duration::from_secs(20)).await;
    println!("appends again {silence:?} after the leader was shut down");
    assert_eq!(messages(&streams, "OUT").await, 102);
}

#[tokio::test(flavor = "multi_thread")]
async fn restarted_servers_keep_only_what_is_on_disk() {
    let Some((mut servers, _scratch)) = cluster(3).await else { return };
    let on_disk = Config { storage: StorageType::File, max_age: Duration::ZERO, ..in_memory("NUM", "num") };
    let streams = jetstream::new(servers.client().await);
    streams.create_stream(in_memory("OUT", "out")).await.unwrap();
    streams.create_stream(on_disk).await.unwrap();
    for subject in ["out.a", "num.a"] {
        append(&streams, subject, (MSG_ID, "1")).await.unwrap();
    }

    // Streams in memory are created again under their names, and are empty.
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
async fn paused_server_and_cut_connection_are_waited_out() {
    let Some((servers, _scratch)) = cluster(1).await else { return };
    let proxy = Proxy::start(servers.address(0)).await;
    let mut streams = jetstream::new(servers::options().connect(proxy.url()).await.unwrap());
    let alone = Config { num_replicas: 1, ..in_memory("OUT", "out") };
    streams.create_stream(alone).await.unwrap();
    streams.set_timeout(Duration::from_millis(300));
    append(&streams, "out.a", (MSG_ID, "before")).await.unwrap();

    proxy.stall();
    append(&streams, "out.a", (MSG_ID, "cut off")).await.unwrap_err();
    proxy.resume();
    stored_within(&streams, "out.a", "cut off", Duration::from_secs(10)).await;

    servers.halt(0);
    append(&streams, "out.a", (MSG_ID, "halted")).await.unwrap_err();
    servers.resume(0);
    stored_within(&streams, "out.a", "halted", Duration::from_secs(10)).await;
    // Each message was sent at least twice, and is stored once.
    assert_eq!(messages(&streams, "OUT").await, 3);
}
