// Work whose length is known by its rounds and that no compiler can leave out.
float timer_work(uint seed, int rounds) {
  float x = float(seed & 1023u) * (1.0 / 1024.0);
  for (int i = 0; i < rounds; ++i) x = fract(x * 1.7 + 0.31 + float(i & 3) * 0.11);
  return x;
}
