//! Request limits: a bucket of requests for each address and each token, refilled over time.
//!
//! For each bucket only the time at which it is full again is stored (generic cell rate algorithm). Full buckets are removed.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use axum::http::StatusCode;

use super::client::Subscriber;
use super::problem::Problem;
use fusion::time::{SECOND, Time};
use site::config::RateLimit;

/// Maximum number of separate buckets. Further owners share one, so that many clients need no more memory.
const BUCKETS: usize = 16_384;

/// Owner of a bucket.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BucketOwner {
    /// A client address.
    Address(Subscriber),
    /// A token, by its hash.
    Token([u8; 32]),
}

/// Limiter of the requests.
#[derive(Debug, Default)]
pub struct RateLimiter {
    buckets: Mutex<Buckets>,
    refused: AtomicU64,
}

impl RateLimiter {
    /// Counts a request with the weight of `weight` usual ones. Returns a problem if the limit is exceeded.
    pub fn charge(
        &self,
        owner: BucketOwner,
        weight: u32,
        limit: Option<RateLimit>,
        now: Time,
    ) -> Result<(), Problem> {
        let Some(limit) = limit else { return Ok(()) };
        let mut buckets = self.buckets.lock().unwrap_or_else(PoisonError::into_inner);
        let Err(wait_ns) = buckets.take(owner, weight, limit, now) else { return Ok(()) };
        self.refused.fetch_add(1, Ordering::Relaxed);
        let whose = match owner {
            BucketOwner::Address(_) => "this address",
            BucketOwner::Token(_) => "this token",
        };
        let mut detail =
            format!("{whose} may ask {} times a second (http.requests_per_s)", limit.requests_per_s);
        if weight > 1 {
            detail += &format!("; what this request asks for counts as {weight} more");
        }
        let wait_s = u32::try_from(wait_ns / SECOND + 1).unwrap_or(u32::MAX);
        Err(Problem::new(StatusCode::TOO_MANY_REQUESTS, detail).retry_after_s(wait_s))
    }

    /// Number of refused requests.
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }
}

#[derive(Debug, Default)]
struct Buckets {
    /// Time at which each bucket is full again, in nanoseconds.
    full_at: HashMap<BucketOwner, i64>,
    /// Time at which the shared bucket is full again.
    shared: i64,
    swept: i64,
}

impl Buckets {
    /// Takes `weight` requests from the bucket, at most its whole capacity. If it has not enough, returns the time until it has,
    /// in nanoseconds.
    fn take(&mut self, owner: BucketOwner, weight: u32, limit: RateLimit, now: Time) -> Result<(), i64> {
        let now = now.nanos();
        // Rounded up, so that the rate is never exceeded.
        let rate = i64::from(limit.requests_per_s);
        let each = (SECOND + rate - 1) / rate;
        let empty = now.saturating_add(each.saturating_mul(limit.burst.into()));
        let full_at = self.bucket(owner, now);
        // A later time occurs only if the clock stepped back or the limit changed.
        *full_at = (*full_at).clamp(now, empty);
        let taken = each.saturating_mul(weight.min(limit.burst).into());
        if *full_at + taken > empty {
            return Err(*full_at + taken - empty);
        }
        *full_at += taken;
        Ok(())
    }

    fn bucket(&mut self, owner: BucketOwner, now: i64) -> &mut i64 {
        if self.full_at.len() >= BUCKETS && !self.full_at.contains_key(&owner) {
            // At most once per second: many clients must not cost a full sweep per request.
            if now.abs_diff(self.swept) >= SECOND as u64 {
                self.swept = now;
                self.full_at.retain(|_, full_at| *full_at > now);
            }
            if self.full_at.len() >= BUCKETS {
                return &mut self.shared;
            }
        }
        self.full_at.entry(owner).or_insert(now)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::net::Ipv4Addr;

    use proptest::prelude::*;

    use super::*;

    fn address(number: u32) -> BucketOwner {
        BucketOwner::Address(Subscriber::at(Ipv4Addr::from(number).into()))
    }

    proptest! {
        /// For any period, any client, and any earlier clock steps.
        #[test]
        fn requests_stay_within_burst_and_rate(
            requests_per_s in 1..100u32,
            burst in 1..50u32,
            steps in prop::collection::vec((0..300_000_000i64, 0..3u32, 1..4u32), 1..400),
            stepped_back_s in 0..100_000i64,
        ) {
            let limit = RateLimit { requests_per_s, burst };
            let mut buckets = Buckets::default();
            let mut now = 1_000_000 * SECOND;
            for owner in 0..3 {
                let _ = buckets.take(address(owner), 1, limit, Time::from_nanos(now + stepped_back_s * SECOND));
            }
            let mut accepted: BTreeMap<u32, Vec<(i64, u32)>> = BTreeMap::new();
            for (step, owner, weight) in steps {
                now += step;
                let weight = weight.min(burst);
                match buckets.take(address(owner), weight, limit, Time::from_nanos(now)) {
                    Ok(()) => accepted.entry(owner).or_default().push((now, weight)),
                    Err(wait) => {
                        // A request succeeds after this time, and not before.
                        prop_assert!(wait > 0);
                        let mut later = Buckets { full_at: buckets.full_at.clone(), ..Buckets::default() };
                        prop_assert!(later.take(address(owner), weight, limit, Time::from_nanos(now + wait - 1)).is_err());
                        prop_assert!(later.take(address(owner), weight, limit, Time::from_nanos(now + wait)).is_ok());
                    }
                }
            }
            for times in accepted.values() {
                for (from, (first, _)) in times.iter().enumerate() {
                    for (to, (last, _)) in times.iter().enumerate().skip(from) {
                        let allowed = f64::from(burst) + f64::from(requests_per_s) * (last - first) as f64 * 1e-9;
                        let taken: u32 = times[from..=to].iter().map(|&(_, weight)| weight).sum();
                        prop_assert!(f64::from(taken) <= allowed + 1e-6);
                    }
                }
            }
        }
    }

    #[test]
    fn request_heavier_than_the_burst_takes_the_whole_bucket() {
        let limit = RateLimit { requests_per_s: 1, burst: 5 };
        let mut buckets = Buckets::default();
        let at = |seconds: i64| Time::from_nanos((1_000 + seconds) * SECOND);
        assert!(buckets.take(address(1), 1_000_000, limit, at(0)).is_ok());
        assert_eq!(buckets.take(address(1), 1, limit, at(0)), Err(SECOND));
        assert!(buckets.take(address(1), 1_000_000, limit, at(5)).is_ok());
    }

    #[test]
    fn many_clients_share_a_bucket_that_expires() {
        let limit = RateLimit { requests_per_s: 1, burst: 1 };
        let mut buckets = Buckets::default();
        let at = |seconds: i64| Time::from_nanos((1_000 + seconds) * SECOND);
        let crowd = 3 * BUCKETS as u32;
        let accepted =
            (0..crowd).filter(|&owner| buckets.take(address(owner), 1, limit, at(0)).is_ok()).count();
        assert_eq!((accepted, buckets.full_at.len()), (BUCKETS + 1, BUCKETS));
        assert!(buckets.take(address(crowd), 1, limit, at(2)).is_ok());
        assert_eq!(buckets.full_at.len(), 1);
    }
}
