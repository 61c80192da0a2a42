import assert from 'node:assert/strict';
import test from 'node:test';
import { categoryColour } from '../src/model/palette';
import { numberRobots } from '../src/model/robot_numbers';

test('robots have the same number whatever order they came in', () => {
  const names = ['alpha', 'bravo', 'charlie', 'delta', 'echo', 'foxtrot', 'golf', 'hotel'];
  const numbers = numberRobots(names);
  assert.deepEqual([...numbers.values()].sort(), [0, 1, 2, 3, 4, 5, 6, 7]);
  assert.deepEqual(numberRobots([...names].reverse()), numbers);
  assert.equal(numberRobots(['bravo']).get('bravo'), numbers.get('bravo'));
});

test('numbers in names count', () => {
  const numbers = numberRobots(['robot2', 'robot10', 'robot3']);
  assert.deepEqual(['robot2', 'robot3', 'robot10'].map((name) => numbers.get(name)), [2, 3, 4]);
});

// The same numbers as in services/tool/export/robot_colours_test.cc.
test('of two names that ask for the same number the first by its bytes has it', () => {
  const inOrder = (...names: string[]) => {
    const numbers = numberRobots(names.toReversed());
    return names.map((name) => numbers.get(name));
  };
  assert.deepEqual(inOrder('robot-1', 'robot_1'), [1, 2]);
  assert.deepEqual(inOrder('Bravo', 'bot'), [1, 2]);
  assert.deepEqual(inOrder('r2', 'r10'), [2, 3]);
  assert.deepEqual(inOrder('r3x', 'r11x'), [3, 4]);
  assert.deepEqual(inOrder('r2', 'r02'), [2, 3]);
  assert.deepEqual(inOrder('z1', 'é1'), [1, 2]);
  assert.deepEqual(inOrder('Ａ1', '😀1'), [1, 2]);
  assert.deepEqual(inOrder('Ünal'), [2]);
  assert.deepEqual(inOrder('alpha', 'bravo', 'charlie', 'Alpha-2', ''), [0, 1, 3, 2, 7]);
});

test('any name has a number, also where there are more than colours', () => {
  const names = ['', '-', '😀', 'Ünal', ...Array.from({ length: 20 }, (_, i) => `x${i}`)];
  const numbers = [...numberRobots(names).values()];
  assert.equal(new Set(numbers).size, names.length);
  assert.deepEqual(numbers.toSorted((a, b) => a - b), [...names.keys()]);
});

test('twenty robots have twenty colours, in either theme', () => {
  for (const theme of ['light', 'dark'] as const) {
    const colours = Array.from({ length: 20 }, (_, number) => categoryColour(theme, number));
    assert.equal(new Set(colours).size, 20);
    for (const colour of colours) assert.match(colour, /^#[0-9a-f]{6}$/);
  }
});
