//! The files that fuzzing the readers begins with: one of each format, as the readers' own tests write them.

use std::path::Path;

use super::{blackbox, dataflash, parse_bytes, ulog, usdlog};

/// Bytes that the fuzz target `usdlog` puts before each input itself.
const USDLOG_HEAD_BYTES: usize = 3;

/// Of a file this share is taken, rather more than the hundred rows of a log: shorter inputs are tried sooner.
const SHARE: f64 = 0.4;

/// A table with all that a free flight has.
fn table() -> Vec<u8> {
    let mut text = "# a comment\ntime_s,roll_rad,pitch_deg,p_rad_s,q_deg_s,motor1,motor2,motor3_pct,motor4,battery_v,\
                    az_m_s2\n"
        .to_owned();
    for row in 0..300 {
        let t = 0.01 * f64::from(row);
        text += &format!("{t:.2},{:.3},-0.5,0.25,1e1,0.5,.5,50,0.5,11.1,-9.81\n", 0.1 * t.sin());
    }
    text.into_bytes()
}

/// A file of each format, with its name.
pub(super) fn seeds() -> [(&'static str, Vec<u8>); 5] {
    [
        ("x.ulg", ulog::tests::whole()),
        ("x.bin", dataflash::tests::whole()),
        ("x.bbl", blackbox::tests::file("Betaflight 4.4.2", "")),
        ("x", usdlog::tests::file(2)),
        ("x.csv", table()),
    ]
}

/// `FUZZ_SEEDS=FOLDER cargo test -p sil-host fuzz_seeds -- --ignored`
#[test]
#[ignore = "writes files: FUZZ_SEEDS names the folder"]
fn are_written() {
    let folder = std::env::var("FUZZ_SEEDS").expect("FUZZ_SEEDS: the folder for the seeds");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
    for (target, (name, mut bytes)) in ["ulog", "dataflash", "blackbox", "usdlog", "csv"].into_iter().zip(seeds()) {
        bytes.truncate((SHARE * bytes.len() as f64) as usize);
        let log = parse_bytes(Path::new(name), bytes.clone(), None).expect("a seed is a log");
        assert!(log.rows() >= 100, "{target}");
        let seeds = folder.join(target);
        std::fs::create_dir_all(&seeds).expect("a folder for the seeds");
        let head = if target == "usdlog" { USDLOG_HEAD_BYTES } else { 0 };
        std::fs::write(seeds.join("seed"), &bytes[head..]).expect("a seed");
    }
}
