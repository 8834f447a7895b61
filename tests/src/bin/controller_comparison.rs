fn main() {
    use integration_tests::comparison::{contender::Contender, draw::Draw, statistics::median};
    let draws: Vec<Draw> = if std::env::var("NOMINAL").is_ok() { (0..4).map(Draw::nominal).collect() } else { (0..20).map(Draw::new).collect() };
    for file in std::env::args().skip(1) {
        let t = std::time::Instant::now();
        let mut c = Contender::new("x", &std::fs::read_to_string(&file).unwrap());
        c.without_bounds = std::env::var("LQI").is_ok();
        if std::env::var("SEG").is_ok() {
            let mut e = vec![[0.0f64; 2]; 17];
            for d in &draws {
                let r = c.fly(&c.setup(d, &sil_host::scenario::Scenario::test_sequence()));
                for i in 0..r.len() {
                    let k = ((r.time_s[i] / 1.75 + 1e-9) as usize).min(16);
                    for a in 0..2 {
                        e[k][a] += (r.angle_rad[i][a] - r.reference_rad[i][a]).to_degrees().powi(2) * 0.0025 / draws.len() as f64;
                    }
                }
            }
            for a in 0..2 { println!("{} {:.1?}", a, e.iter().map(|x| x[a]).collect::<Vec<_>>()); }
        }
        if let Ok(at) = std::env::var("TRACE") {
            let at: f64 = at.parse().unwrap();
            let r = c.fly(&c.setup(&Draw::nominal(0), &sil_host::scenario::Scenario::test_sequence()));
            for i in (0..r.len()).step_by(4).filter(|&i| r.time_s[i] >= at - 0.02 && r.time_s[i] < at + 0.7) {
                println!("{:.3} ref {:6.2} {:6.2} ang {:6.2} {:6.2} tau {:.3} {:.3} cmd {:.2?}", r.time_s[i] - at, r.shaped_reference_rad[i][0].to_degrees(), r.shaped_reference_rad[i][1].to_degrees(), r.angle_rad[i][0].to_degrees(), r.angle_rad[i][1].to_degrees(), r.torque_body_nm[i][0], r.torque_body_nm[i][1], r.commands[i]);
            }
        }
        let f = c.fly_all(&draws);
        let m = |g: &dyn Fn(&integration_tests::comparison::contender::Figures) -> f64| {
            median(&f.iter().map(g).collect::<Vec<_>>())
        };
        println!(
            "{file}: rms {:.3} r {:.3} p {:.3} over {:.2} settle {:.3} steady {:.2} effort {:.4} sat {:.1} cost {:.3}  {:?}",
            m(&|f| f.rms_deg),
            m(&|f| f.axis_rms_deg[0]),
            m(&|f| f.axis_rms_deg[1]),
            m(&|f| f.overshoot_pct),
            m(&|f| f.settling_s),
            m(&|f| f.steady_error_deg),
            m(&|f| f.effort),
            m(&|f| f.saturated_pct),
            c.cost(&draws),
            t.elapsed()
        );
    }
}
