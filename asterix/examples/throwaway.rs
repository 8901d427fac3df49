use asterix::*;
use std::time::Instant;
fn main() {
    #![allow(warnings)]
    let f = std::env::args().nth(1).unwrap();
    let d = std::fs::read(f).unwrap();
    let mut best = 0f64;
    let mut enc = 0f64;
    println!(
        "size {} {}",
        std::mem::size_of::<cat048::Record>(),
        std::mem::size_of::<Option<Result<Located<cat048::Record>, Fault>>>()
    );
    for _ in 0..20 {
        let t = Instant::now();
        let mut n = 0u64;
        let mut s = 0.0;
        let mut faults = 0;
        for b in blocks(&d) {
            let Ok(b) = b else {
                faults += 1;
                continue;
            };
            if b.category != 48 {
                continue;
            }
            for r in b.records::<cat048::Record>() {
                match r {
                    Ok(r) => {
                        n += 1;
                        if let Some(p) = r.record.polar_position {
                            s += p.range_m();
                        }
                        if let Some(f) = r.record.flight_level {
                            s += f.flight_level()
                        }
                    }
                    Err(e) => {
                        faults += 1;
                        if n < 100 {
                            println!("{e}")
                        }
                    }
                }
            }
        }
        let v = n as f64 / t.elapsed().as_secs_f64();
        if v > best {
            best = v
        }
        if best == v {
            println!("{n} records {faults} faults {s} {:.2} M/s", v / 1e6)
        }
    }
    let recs: Vec<Vec<cat048::Record>> = blocks(&d)
        .flatten()
        .filter(|b| b.category == 48)
        .map(|b| b.records::<cat048::Record>().flatten().map(|l| l.record).collect())
        .collect();
    let n: usize = recs.iter().map(|r| r.len()).sum();
    let mut out = Vec::with_capacity(d.len());
    for _ in 0..10 {
        out.clear();
        let t = Instant::now();
        for b in &recs {
            encode_block(b, &mut out).unwrap();
        }
        let v = n as f64 / t.elapsed().as_secs_f64();
        if v > enc {
            enc = v
        }
    }
    println!("encode {:.2} M/s same {}", enc / 1e6, out == d);
}
