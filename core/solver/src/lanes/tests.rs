use super::plain::in_double;
use super::*;

fn wave(i: usize) -> f32 {
    (1.7 * i as f32).sin() * 10_f32.powi((i % 7) as i32 - 3)
}

#[test]
fn a_sum_with_a_product_is_rounded_once() {
    let odd = [0.0, -0.0, 1.0, f32::MIN_POSITIVE, 1e-42, f32::MAX, -f32::MAX, f32::INFINITY, 1.0 + f32::EPSILON];
    let near = |i: usize| f32::from_bits(0x3f80_0000 + (i as u32).wrapping_mul(2_654_435_761) % 64);
    let mut cases: Vec<[f32; 3]> = (0..20_000).map(|i| [wave(i), wave(3 * i + 1), wave(7 * i + 2)]).collect();
    // Where the product all but cancels, and where the rest is far below the last digit.
    cases.extend((0..20_000).map(|i| [near(i), near(i / 7), -near(i / 3)]));
    cases.extend((0..20_000).map(|i| [near(i), near(i / 5), near(i / 3) * 2_f32.powi(-(20 + i as i32 % 30))]));
    // A little less than half a digit more, which double precision makes a half.
    let less = |k: usize| [1.0 + 2_f32.powi(-15 - k as i32 % 5), 1.0 - 2_f32.powi(-15 - k as i32 % 5)];
    cases.extend((0..100).map(|k| [less(k)[0], less(k)[1] * 2_f32.powi(-24), 1.0 + (k / 5) as f32 * f32::EPSILON]));
    cases.extend(odd.iter().flat_map(|a| odd.iter().flat_map(move |b| odd.map(|c| [*a, *b, c]))));
    for [a, b, c] in cases {
        let (got, want) = (in_double(a, b, c), a.mul_add(b, c));
        assert!(
            got.to_bits() == want.to_bits() || (got.is_nan() && want.is_nan()),
            "{a:e} {b:e} {c:e}: {got:e} {want:e}"
        );
    }
}

/// With numbers that are found before: how powers are rounded depends on what they are compiled for.
#[derive(Clone, Copy)]
struct All<'a>(&'a [f32]);

impl Work for All<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn on(self, unit: impl Lanes) -> Vec<u32> {
        let wave = |i: usize| self.0[i];
        let of = |first: usize| std::array::from_fn::<_, 16, _>(|l| wave(first + l));
        let [a, b, mut c] = [of(0), of(20), of(40)].map(|v| unit.load(&v));
        let tiny = unit.load(&of(60));
        c = unit.fnma(a, unit.mul(b, c), unit.fma(a, b, unit.sub(c, unit.add(a, b))));
        let vectors: [Quad; 16] = std::array::from_fn(|i| [wave(3 * i), wave(3 * i + 1), wave(3 * i + 2), 0.0]);
        let planes = unit.planes(load(unit, &vectors));
        for (component, plane) in planes.into_iter().enumerate() {
            assert_eq!(unit.store(plane), vectors.map(|v| v[component]));
        }
        let mut again = [[1.0; 4]; 16];
        store(unit, &mut again, unit.vectors(planes));
        assert_eq!(again, vectors);
        let numbers: Quad = std::array::from_fn(|k| wave(5 * k + 2));
        assert_eq!(unit.store(unit.each_four(&numbers)), std::array::from_fn(|l| numbers[l / 4]));
        let [at_0, at_1, at_2, at_3]: [Quad; 4] = std::array::from_fn(|k| std::array::from_fn(|c| wave(4 * k + c)));
        let sum = std::array::from_fn(|k| (at_0[k] + at_2[k]) + (at_1[k] + at_3[k]));
        assert_eq!(unit.sum_of_four(a), sum);
        let blocks: [[f64; 9]; 16] = std::array::from_fn(|i| std::array::from_fn(|e| (1.3 * (9 * i + e) as f64).sin()));
        let single = blocks.map(|block| block.map(|value| value as f32));
        let both = [unit.entries(blocks.each_ref(), 0.25), unit.entries(single.each_ref(), 0.25)];
        for (e, entries) in both.into_iter().flat_map(|entries| entries.into_iter().enumerate()) {
            assert_eq!(unit.store(entries), blocks.map(|block| (0.25 * block[e]) as f32));
        }
        let wide: [f64; 16] = std::array::from_fn(|l| 1.1 * f64::from(wave(l + 9)));
        assert_eq!(unit.store(unit.round(&wide)), wide.map(|value| value as f32));
        for first in [0, 16] {
            let places = std::array::from_fn(|l| ((11 * (first + l) + 3) % LOOKED_UP) as u8);
            let found = unit.store(unit.lookup([unit.load(&of(7)), unit.load(&of(23))], &places));
            assert_eq!(found, places.map(|at| wave(7 + at as usize)));
        }
        exact(unit, self.0);
        [c, unit.flush_denormals(tiny)].map(|v| unit.store(v).map(f32::to_bits)).concat()
    }
}

/// In double precision, whatever is taken at once.
fn exact<U: Lanes>(unit: U, numbers: &[f32]) {
    let wide: Vec<f64> = numbers.iter().map(|v| 1.1 * f64::from(*v)).collect();
    for at in (0..16).step_by(U::EXACT) {
        let (a, b) = (unit.exact(&numbers[at..]), unit.load_exact(&wide[at + 7..]));
        let c = unit.sub_exact(unit.load_exact(&wide[at + 30..]), b);
        let (mut sum, mut rest) = ([0.0; 16], [0.0; 16]);
        unit.store_exact(unit.add_product(a, b, c), &mut sum);
        unit.store_exact(unit.take_product(a, b, c), &mut rest);
        for lane in 0..U::EXACT {
            let product = f64::from(numbers[at + lane]) * wide[at + 7 + lane];
            let c = wide[at + 30 + lane] - wide[at + 7 + lane];
            assert_eq!([sum[lane], rest[lane]], [product + c, c - product]);
        }
    }
}

#[test]
fn every_vector_unit_does_the_same() {
    let tiny = (0..16).map(|l| 10_f32.powi(-10 - l) * wave(l as usize));
    let numbers: Vec<f32> = (0..60).map(wave).chain(tiny).collect();
    let all = All(&numbers);
    let first = all.on(Plain);
    assert!(first[16..32].contains(&0) && first[16..32].iter().any(|bits| *bits != 0));
    assert!(Unit::ALL.iter().all(|unit| unit.run(all) == first));
}
