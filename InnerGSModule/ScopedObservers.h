#pragma once
#include <vtkObject.h>
#include <vtkWeakPointer.h>

#include <initializer_list>
#include <vector>

/// Observers of VTK objects, removed with this. The objects may be deleted earlier.
class ScopedObservers {
public:
  ScopedObservers() = default;
  ~ScopedObservers() { clear(); }
  ScopedObservers(const ScopedObservers&) = delete;
  ScopedObservers& operator=(const ScopedObservers&) = delete;

  template <class Owner>
  void add(vtkObject* object, std::initializer_list<unsigned long> events, Owner* owner,
           void (Owner::*method)(vtkObject*, unsigned long, void*)) {
    for (const unsigned long event : events)
      if (object) list_.push_back({object, object->AddObserver(event, owner, method)});
  }
  void clear() {
    for (const Observation& observation : list_)
      if (observation.object) observation.object->RemoveObserver(observation.tag);
    list_.clear();
  }

private:
  struct Observation {
    vtkWeakPointer<vtkObject> object;
    unsigned long tag;
  };
  std::vector<Observation> list_;
};
