//! exploration
use campaigns::adaptation::flight::{Knows, Vehicle};
use campaigns::comparison::weather::Weather;
use rayon::prelude::*;
use sil_host::model::Rig;
use sil_host::scenario::Scenario;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let n: u64 = args[1].parse().unwrap();
    let rig = if args.get(2).is_some_and(|a| a == "free") { Rig::Free } else { Rig::Gimbal };
    let scenario = Scenario::test_sequence();
    let rows: Vec<_> = (1..=n).into_par_iter().map(|seed| {
        let v = match std::env::var("ONE") { Ok(t) => { let x: Vec<f64> = t.split(',').map(|x| x.parse().unwrap()).collect(); Vehicle { seed, gain: [x[0], x[1]], lag_s: x[2], thrust: x[3], ring_moment_nm: 0.0 } } Err(_) => Vehicle::drawn(seed, rig) };
        (v, [Knows::Wrong, Knows::Right, Knows::Learns].map(|k| v.fly(rig, k, Weather::Still, &scenario)))
    }).collect();
    let sum = |f: &dyn Fn(&[campaigns::adaptation::flight::Outcome;3])->f64| rows.iter().map(|(_, o)| f(o)).filter(|x| x.is_finite()).sum::<f64>();
    let (w, r, l) = (sum(&|o| o[0].late_rms_deg), sum(&|o| o[1].late_rms_deg), sum(&|o| o[2].late_rms_deg));
    println!("late: wrong {:.3} right {:.3} learns {:.3} recovered {:.3}", w/n as f64, r/n as f64, l/n as f64, (w-l)/(w-r));
    let worst = rows.iter().map(|(_, o)| o[2].late_rms_deg/o[0].late_rms_deg).fold(0.0, f64::max);
    println!("worst learn/wrong {worst:.3}");
    let all: Vec<_> = rows.iter().flat_map(|(_, o)| &o[2].changes).collect();
    println!("changes {} refused {} holds lag {} gains {}/{}", all.len(), all.iter().filter(|c| c.refused.is_some()).count(), all.iter().filter(|c| c.holds[2]==Some(true)).count(),
        all.iter().flat_map(|c| &c.holds[..2]).filter(|h| **h==Some(true)).count(), all.iter().flat_map(|c| &c.holds[..2]).filter(|h| h.is_some()).count());
    let firsts: Vec<(f64, f64, f64)> = rows.iter().flat_map(|(v, o)| o[2].changes.first().map(|c| ((c.gain[0] / v.gain[0] - 1.0).abs(), (c.lag_s / (v.lag_s + if rig == Rig::Free { 0.0528 } else { 0.002 }) - 1.0).abs(), c.after_s))).collect();
    let within = |f: &dyn Fn(&(f64,f64,f64)) -> bool| firsts.iter().filter(|x| f(x)).count();
    println!("first {} of {}: gain within 10 % {}, lag {} (5 %: {} {}), in 1 s {}", firsts.len(), n, within(&|x| x.0 < 0.1), within(&|x| x.1 < 0.1), within(&|x| x.0 < 0.05), within(&|x| x.1 < 0.05), within(&|x| x.2 < 1.0));
    for (v, [wrong, right, learns]) in &rows {
        println!("seed {} gain {:.2} {:.2} lag {:.1} ms: rms {:.2} {:.2} {:.2}, late {:.2} {:.2} {:.2}; end {:.2} {:.2} {:.1}", v.seed, v.gain[0], v.gain[1], v.lag_s*1e3+2.0,
            wrong.rms_deg, right.rms_deg, learns.rms_deg, wrong.late_rms_deg, right.late_rms_deg, learns.late_rms_deg, learns.model[0], learns.model[1], learns.model[2]*1e3);
        for c in &learns.changes {
            println!("     {:.2} s: {:.2} {:.2} {:.1} ms holds {:?} half {:.2?} refused {:?}", c.after_s, c.gain[0], c.gain[1], c.lag_s*1e3, c.holds, c.half_width, c.refused);
        }
    }
}
