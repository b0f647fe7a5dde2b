#pragma once
#include "MrmlFixture.h"

/// A model to ask.
class QueryTest : public MrmlFixture {
protected:
  QueryTest() {
    EXPECT_TRUE(logic->Reconstruct(addParameters(addVolume()))) << logic->GetLastError();
    model = logic->GetLastJob()->GetModelNode();
  }
  vtkMRMLInnerGSModelNode* model = nullptr;
};
