use super::{Show, Wish, plan};

const WISH: Wish = Wish {
    travel: 4e-3,
    speed: 2e-3,
    acceleration: 0.1,
    smallest: 4e-6,
    show: Show::All,
    repeats: 3,
    rate: 400.0,
};

#[test]
fn a_plan_meets_the_request_and_ends_where_it_began() {
    for show in [Show::Presliding, Show::Sliding, Show::All] {
        let plan = plan(&Wish { show, ..WISH }).expect("a plan");
        let x: Vec<f64> = plan.rows.iter().map(|row| row.0).collect();
        let dt = 1.0 / WISH.rate;
        let speeds: Vec<f64> = x.windows(2).map(|p| (p[1] - p[0]) / dt).collect();
        let fastest = speeds.iter().map(|v| v.abs()).fold(0.0, f64::max);
        let steepest = speeds
            .windows(2)
            .map(|v| (v[1] - v[0]).abs() / dt)
            .fold(0.0, f64::max);
        let furthest = x.iter().map(|x| x.abs()).fold(0.0, f64::max);
        assert!(
            fastest <= WISH.speed && fastest > 0.5 * WISH.speed,
            "{show:?}: {fastest}"
        );
        assert!(steepest <= WISH.acceleration, "{show:?}: {steepest}");
        assert!(
            furthest <= 0.5 * WISH.travel * (1.0 + 1e-12),
            "{show:?}: {furthest}"
        );
        assert_eq!((x[0], x[x.len() - 1]), (0.0, 0.0));
        assert_eq!(plan.rows.last().map(|row| row.1), Some(WISH.repeats));
    }
}

#[test]
fn nested_reversals_shrink_below_the_smallest_stroke_twice_and_begin_at_different_places() {
    let found = plan(&Wish {
        show: Show::Presliding,
        ..WISH
    })
    .expect("a plan");
    assert!(found.strokes.0 < 2.0 * WISH.smallest, "{:?}", found.strokes);
    // Three stations, at least a dozen reversals at each, three repeats.
    assert!(found.reversals > 100, "{}", found.reversals);
    // Turning points in at least three places that are far apart.
    let turns: Vec<f64> = found
        .rows
        .windows(3)
        .filter(|w| (w[1].0 - w[0].0) * (w[2].0 - w[1].0) < 0.0)
        .map(|w| w[1].0)
        .collect();
    for station in [-1.22e-3, 0.14e-3, 1.06e-3] {
        let near = turns
            .iter()
            .filter(|x| (**x - station).abs() < 0.25e-3)
            .count();
        assert!(near > 30, "{near} turns near {station}");
    }
}

#[test]
fn everything_that_is_wrong_is_named_at_once() {
    let error = plan(&Wish {
        travel: -1.0,
        speed: f64::NAN,
        repeats: 0,
        ..WISH
    })
    .expect_err("wrong");
    for name in ["--travel", "--speed", "--repeats", "--smallest"] {
        assert!(error.contains(name), "{error}");
    }
}

/// As long as it would be: nothing is made of it first.
#[test]
fn a_plan_without_end_is_refused_with_its_length() {
    for (wish, says) in [
        (
            Wish {
                speed: 1e-8,
                ..WISH
            },
            ["minutes", "--speed"],
        ),
        (Wish { rate: 1e9, ..WISH }, ["rows", "--rate"]),
    ] {
        let error = plan(&wish).expect_err("too long");
        assert!(says.iter().all(|word| error.contains(word)), "{error}");
    }
}
