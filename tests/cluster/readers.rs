//! Reading from a sequence on with a subject filter, across failures of the consumer.

use std::time::{Duration, Instant};

use async_nats::jetstream;
use async_nats::jetstream::consumer::{AckPolicy, DeliverPolicy, pull};
use async_nats::jetstream::stream::{Config, DirectGetErrorKind};
use fusion::slots::Slot;
use futures_util::{FutureExt, StreamExt};
use utm_fusion::cluster::{AppendResult, CellOutput, Checkpoint, Log, Mark, SheddingLevel};
use utm_fusion::config::Cluster;

use crate::servers::Servers;
use crate::{append, cluster, in_memory};

/// A consumer without replicas for all matching messages from that sequence on, and the name of its server.
async fn consumer(streams: &jetstream::Context, from: u64, filter: &str) -> Option<(pull::Stream, String)> {
    let config = pull::Config {
        deliver_policy: DeliverPolicy::ByStartSequence { start_sequence: from },
        filter_subject: filter.to_owned(),
        ack_policy: AckPolicy::None,
        inactive_threshold: Duration::from_secs(10),
        num_replicas: 1,
        memory_storage: true,
        ..pull::Config::default()
    };
    let consumer = streams.create_consumer_on_stream(config, "IN").await.ok()?;
    let server = consumer.cached_info().cluster.as_ref()?.leader.clone()?;
    // Small batches, so that the server is killed between them.
    let requests = consumer.stream().max_messages_per_batch(5).expires(Duration::from_secs(5));
    Some((requests.heartbeat(Duration::from_millis(500)).messages().await.ok()?, server))
}

#[tokio::test(flavor = "multi_thread")]
async fn reader_continues_after_its_server_was_killed() {
    let Some((mut servers, _scratch)) = cluster(3).await else { return };
    let mut streams = jetstream::new(servers.client().await);
    streams.create_stream(Config { allow_direct: true, ..in_memory("IN", "in") }).await.unwrap();
    streams.set_timeout(Duration::from_secs(1));
    let mut wanted = Vec::new();
    for number in 0..200 {
        let subject = if number % 4 == 0 { "in.1.2" } else { "in.1.3" };
        let sequence =
            append(&streams, subject, ("Nats-Msg-Id", &number.to_string())).await.unwrap().sequence;
        if sequence >= 50 && number % 4 == 0 {
            wanted.push(sequence);
        }
    }

    let (mut read, mut from, mut killed) = (Vec::new(), 50, None);
    let began = Instant::now();
    while read.len() < wanted.len() {
        assert!(began.elapsed() < Duration::from_secs(30), "{} of {}", read.len(), wanted.len());
        let Some((mut messages, server)) = consumer(&streams, from, "in.1.2").await else {
            // The servers have no leader, and answer at once.
            tokio::time::sleep(Duration::from_millis(50)).await;
            continue;
        };
        // The loop ends if a heartbeat is missing or the consumer is gone.
        while read.len() < wanted.len()
            && let Some(Ok(message)) = messages.next().await
        {
            let sequence = message.info().unwrap().stream_sequence;
            read.push(sequence);
            from = sequence + 1;
            if read.len() == 10 {
                servers.kill(servers.index_of(&server));
                killed = Some(Instant::now());
            }
        }
    }
    println!("read on and to the end within {:?} of that server's end", killed.unwrap().elapsed());
    assert_eq!(read, wanted);
    assert_eq!(without_a_consumer(&streams, 50, "in.1.2").await, wanted);
}

/// Reads the same messages one by one, which any server of the stream answers, even without a leader.
async fn without_a_consumer(streams: &jetstream::Context, mut from: u64, filter: &str) -> Vec<u64> {
    let stream = streams.get_stream_no_info("IN").await.unwrap();
    let (mut read, began) = (Vec::new(), Instant::now());
    loop {
        match stream.direct_get_next_for_subject(filter, Some(from)).await {
            Ok(message) => {
                read.push(message.sequence);
                from = message.sequence + 1;
            }
            Err(error) if error.kind() == DirectGetErrorKind::NotFound => return read,
            Err(error) => assert!(began.elapsed() < Duration::from_secs(20), "{error}"),
        }
    }
}

/// The streams of a separate region.
async fn log_of(servers: &Servers) -> Log {
    let settings = Cluster {
        servers: servers.urls(),
        node: "reader".to_owned(),
        region: "reads".to_owned(),
        replicas: 1,
        ..Cluster::default()
    };
    Log::open(&settings).await.unwrap()
}

/// The picture checks every 20 ms, and other readers wait for two streams at once: a cancelled wait must not restart the reader
/// or its timeout.
#[tokio::test(flavor = "multi_thread")]
async fn cancelled_reads_lose_no_message() {
    let Some((servers, _scratch)) = cluster(1).await else { return };
    let log = log_of(&servers).await;
    let output = |slot: i64| CellOutput {
        slot: Slot(slot),
        epoch: 1,
        refused: Vec::new(),
        after_input: 1,
        level: SheddingLevel::default(),
        picture: vec![7; 100],
    };
    let mut reading = log.outputs("cell", 1);
    let (mut read, mut given_up) = (Vec::new(), 0);
    for slot in 0..200_u64 {
        assert_eq!(log.append("cell", slot, &output(slot as i64)).await, AppendResult::Stored(slot + 1));
    }
    let began = Instant::now();
    while read.len() < 200 {
        // Poll once without waiting: work that restarted with every call would never be completed.
        match reading.next().now_or_never() {
            Some(message) => read.push(message.expect("the stream is there").0),
            None => {
                given_up += 1;
                tokio::time::sleep(Duration::from_millis(1)).await;
            }
        }
        assert!(
            began.elapsed() < Duration::from_secs(20),
            "{} of 200 read, {given_up} times given up",
            read.len()
        );
    }
    println!("read within {:.2} s, {given_up} times given up", began.elapsed().as_secs_f64());
    assert!(given_up > 0 && read == (1..=200).collect::<Vec<u64>>(), "{read:?}");
    let streams = jetstream::new(servers.client().await);
    let mut stream = streams.get_stream("UTM_OUT_reads").await.unwrap();
    let readers = stream.info().await.unwrap().state.consumer_count;
    assert!(readers <= 2, "{readers} readers were made for one");
}

/// A reader whose checkpoint is replaced during reading reads the next one.
#[tokio::test(flavor = "multi_thread")]
async fn checkpoint_is_read_while_being_replaced() {
    let Some((servers, _scratch)) = cluster(1).await else { return };
    let log = log_of(&servers).await;
    let checkpoint = |published| Checkpoint {
        mark: Mark { input: 1, output: 2 },
        handled: 3,
        published,
        engine: vec![7; 300_000],
    };
    log.put_checkpoint("all", &checkpoint(0)).await.unwrap();
    let (writer, began) = (log.clone(), Instant::now());
    let writing = tokio::spawn(async move {
        for published in 1.. {
            writer.put_checkpoint("all", &checkpoint(published)).await.unwrap();
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    });
    let (mut before, mut longest) = (0, Duration::ZERO);
    for _ in 0..300 {
        let asked = Instant::now();
        let read = tokio::time::timeout(Duration::from_secs(20), log.checkpoint("all")).await;
        let read = read.expect("it ends").unwrap().expect("there is one");
        longest = longest.max(asked.elapsed());
        assert!(
            read.published >= before && read.engine.len() == 300_000,
            "{} behind {before}",
            read.published
        );
        before = read.published;
    }
    writing.abort();
    println!("of {before} written in {:?} 300 read, the slowest in {longest:?}", began.elapsed());
    assert!(before > 100, "none took its place: {before}");
}
