use integration_tests::comparison::{contender::Figures, draw::Draw, statistics::median, tuning::*};
fn show<const N: usize>(c: Tunable<N>, n: usize) {
    let tuning: Vec<Draw> = (1000..1012).map(Draw::new).collect();
    let draws: Vec<Draw> = (0..20).map(Draw::new).collect();
    let found = c.tune(&tuning, n, 1);
    println!("{}", c.file(&found.point));
    let f = c.contender(&found.point).fly_all(&draws);
    let m = |g: &dyn Fn(&Figures) -> f64| median(&f.iter().map(g).collect::<Vec<_>>());
    println!(
        "rms {:.3} r {:.3} p {:.3} over {:.2} settle {:.3} steady {:.2} effort {:.4} sat {:.1} cost {:.3}",
        m(&|f| f.rms_deg),
        m(&|f| f.axis_rms_deg[0]),
        m(&|f| f.axis_rms_deg[1]),
        m(&|f| f.overshoot_pct),
        m(&|f| f.settling_s),
        m(&|f| f.steady_error_deg),
        m(&|f| f.effort),
        m(&|f| f.saturated_pct),
        m(&|f| f.cost())
    );
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n: usize = a[2].parse().unwrap();
    let (g, s) = (&a[3], &a[4]);
    let shaping =
        format!("shaping_gain_1_s = [{g}, {g}, 3.0]\nacceleration_share = {s}\nrate_max_rad_s = [8.0, 8.0, 2.0]\n");
    let p = |field, form, start| Parameter { field, form, start };
    let t = |yaw| Form::Tilt { pitch: 1.0, yaw };
    if a[1] == "pid" {
        show(
            Tunable {
                name: "cascade",
                fixed: format!("controller = \"pid\"\n[tuning]\n{shaping}"),
                parameters: [
                    p("angle_gain_1_s", t(3.0), 22.0),
                    p("rate_proportional_1_s", t(9.0), 27.0),
                    p("rate_integral_1_s2", t(9.0), 33.0),
                    p("rate_derivative", t(0.0), 1.17),
                    p("rate_derivative_cutoff_hz", Form::Number, 15.0),
                    p("acceleration_feed_forward", Form::Number, 0.75),
                ],
            },
            n,
        )
    } else {
        show(
            Tunable {
                name: "mpc",
                fixed: format!("controller = \"mpc\"\ncontrol_horizon = 10\n[tuning]\n{shaping}"),
                parameters: [
                    p("mpc_increment_weight", Form::Tilt { pitch: 0.0991, yaw: 3000.0 }, 1.0),
                    p("mpc_disturbance_bandwidth_rad_s", Form::Number, 10.0),
                    p("mpc_prediction_step_s", Form::Number, 0.01),
                    p("gyro_cutoff_hz", Form::Number, 100.0),
                ],
            },
            n,
        )
    }
}
