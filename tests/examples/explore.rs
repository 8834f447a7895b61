use integration_tests::comparison::{contender::Figures, draw::Draw, statistics::median, tuning::*};
fn main() {
    let tuning: Vec<Draw> = (1000..1012).map(Draw::new).collect();
    let draws: Vec<Draw> = (0..20).map(Draw::new).collect();
    let n: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    let p = |field, form, start| Parameter { field, form, start };
    let t = |yaw| Form::Tilt { yaw };
    let c = Tunable {
        name: "cascade",
        fixed: "controller = \"pid\"\n[tuning]\nrate_max_rad_s = [8.0, 8.0, 2.0]\n".into(),
        parameters: [
            p("shaping_gain_1_s", t(3.0), 7.0),
            p("acceleration_share", Form::Number, 0.9),
            p("angle_gain_1_s", t(3.0), 6.64),
            p("rate_proportional_1_s", t(9.0), 23.0),
            p("rate_integral_1_s2", t(9.0), 46.0),
            p("rate_derivative", t(0.0), 0.75),
            p("rate_derivative_cutoff_hz", Form::Number, 40.0),
            p("acceleration_feed_forward", Form::Number, 0.5),
        ],
    };
    let found = c.tune(&tuning, n, 1);
    println!("{}", c.file(&found.point));
    let f = c.contender(&found.point).fly_all(&draws);
    let m = |g: &dyn Fn(&Figures) -> f64| median(&f.iter().map(g).collect::<Vec<_>>());
    println!(
        "rms {:.3} r {:.3} p {:.3} over {:.2} settle {:.3} steady {:.2} effort {:.4} sat {:.1}",
        m(&|f| f.rms_deg),
        m(&|f| f.axis_rms_deg[0]),
        m(&|f| f.axis_rms_deg[1]),
        m(&|f| f.overshoot_pct),
        m(&|f| f.settling_s),
        m(&|f| f.steady_error_deg),
        m(&|f| f.effort),
        m(&|f| f.saturated_pct)
    );
}
