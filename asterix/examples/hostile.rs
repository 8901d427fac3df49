//! x
#![allow(warnings)]
use asterix::*;
use std::collections::*;
fn main() {
    for f in std::env::args().skip(1) {
        let d = std::fs::read(&f).unwrap();
        let mut p = 24;
        let u = |i: usize| u32::from_le_bytes(d[i..i + 4].try_into().unwrap()) as usize;
        let mut counts: BTreeMap<String, u64> = BTreeMap::new();
        let mut last: HashMap<Vec<u8>, f64> = HashMap::new();
        while p + 16 <= d.len() {
            let t = u(p) as f64 + u(p + 4) as f64 * 1e-6;
            let n = u(p + 8);
            let pk = &d[p + 16..p + 16 + n];
            p += 16 + n;
            if pk.len() < 42 {
                *counts.entry("short".into()).or_default() += 1;
                continue;
            }
            let ihl = ((pk[14] & 15) as usize) * 4;
            let l = u16::from_be_bytes([pk[14 + ihl + 4], pk[14 + ihl + 5]]) as usize;
            let o = 14 + ihl + 8;
            let dg = &pk[o..(o + l - 8).min(pk.len())];
            if let Some(&q) = last.get(dg) {
                if t - q <= 2.0 {
                    *counts.entry("identical".into()).or_default() += 1;
                    continue;
                }
            }
            last.insert(dg.to_vec(), t);
            for b in blocks(dg) {
                match b {
                    Err(e) => {
                        *counts.entry(format!("fault {}", e.kind.name())).or_default() += 1;
                    }
                    Ok(b) => {
                        fn go<R: Record>(b: &Block, counts: &mut BTreeMap<String, u64>) {
                            let mut re = vec![];
                            let mut ok = true;
                            for r in b.records::<R>() {
                                match r {
                                    Ok(r) => {
                                        *counts.entry(format!("records {}", R::CATEGORY)).or_default() += 1;
                                        r.record.encode_into(&mut re)
                                    }
                                    Err(e) => {
                                        ok = false;
                                        println!("{e}");
                                        *counts.entry(format!("fault {}", e.kind.name())).or_default() += 1;
                                    }
                                }
                            }
                            if ok {
                                assert_eq!(re, b.contents())
                            }
                        }
                        match b.category {
                            48 => go::<cat048::Record>(&b, &mut counts),
                            129 => go::<cat129::Record>(&b, &mut counts),
                            c => {
                                *counts.entry(format!("category {c}")).or_default() += 1;
                            }
                        }
                    }
                }
            }
        }
        println!("{f} {counts:#?}");
    }
}
