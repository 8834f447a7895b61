fn main() {
    use integration_tests::comparison::{contender::Contender, draw::Draw, statistics::median};
    let draws: Vec<Draw> = (0..20).map(Draw::new).collect();
    for file in std::env::args().skip(1) {
        let t = std::time::Instant::now();
        let c = Contender::new("x", &std::fs::read_to_string(&file).unwrap());
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
